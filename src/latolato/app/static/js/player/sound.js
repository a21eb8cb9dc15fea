/** What a motion sounds like: clacks and the tones of angles, silent until asked for. */

import { makeBurst, playClack } from "./clack.js";
import { Tone } from "./tone.js";

// Clacks are heard so much after their picture, whenever in a frame they happen.
const DELAY = 0.02; // s
// Clacks follow each other by at least this time, however fast the motion is.
const PAUSE = 0.03; // s
// Softer ones are not heard; the softest that are have this loudness.
const SOFTEST = 0.01;
const LEAST = 0.05;
// A limiter that adds no delay: it bends loud sounds smoothly to below full volume.
const LIMIT = Float32Array.from({ length: 1025 }, (_, i) => 0.9 * Math.tanh((i - 512) / 256));

export class Sound {
  /** @param {() => BaseAudioContext} make */
  constructor(make = () => new AudioContext()) {
    this.make = make;
    this.clacks = false;
    this.tones = false;
    /** @type {{context: BaseAudioContext, out: AudioNode, burst: AudioBuffer, voices: Tone[]} | null} */
    this.opened = null;
    this.last = -PAUSE;
  }

  /** Return the sound card, null before anybody has touched the page: browsers refuse it. */
  open() {
    if (this.opened || !navigator.userActivation.hasBeenActive) return this.opened;
    const context = this.make();
    const out = new WaveShaperNode(context, { curve: LIMIT });
    out.connect(context.destination);
    this.opened = { context, out, burst: makeBurst(context), voices: [] };
    return this.opened;
  }

  /**
   * Play the sound of balls that met, the louder the faster.
   * @param {number} ago [s]
   * @param {number} loudness from 0 to 1
   * @param {"bottom" | "top"} kind
   */
  clack(ago, loudness, kind) {
    if (!this.clacks || loudness < SOFTEST) return;
    const opened = this.open();
    if (!opened) return;
    const { context, out, burst } = opened;
    const at = context.currentTime + Math.max(0, DELAY - ago);
    if (at - this.last < PAUSE) return;
    this.last = at;
    playClack(burst, out, at, Math.min(Math.max(loudness, LEAST), 1), kind);
  }

  /**
   * Play the angle of each ball as a tone.
   * @param {number[]} angles [rad]
   */
  follow(angles) {
    if (!this.tones) return;
    const opened = this.open();
    if (!opened) return;
    const { context, out, voices } = opened;
    while (voices.length < angles.length) voices.push(new Tone(context, out));
    angles.forEach((angle, i) => voices[i].follow(angle));
  }

  /** Give the sound card back. */
  close() {
    if (this.opened?.context instanceof AudioContext) void this.opened.context.close();
    this.opened = null;
    this.clacks = this.tones = false;
  }
}
