/** The sound of two balls that meet. */

const LENGTH = 0.05; // s
const PITCH = 2400; // Hz
// Clacks follow each other by at least this time, however fast the run is played.
const PAUSE = 0.03; // s

export class Clack {
  constructor() {
    this.on = false;
    /** @type {AudioContext | null} */
    this.context = null;
    this.last = 0;
  }

  /**
   * Sound once, the louder the faster the balls met.
   * @param {number} loudness from 0 to 1
   */
  sound(loudness) {
    if (!this.on) return;
    this.context ??= new AudioContext();
    const { context } = this;
    const now = context.currentTime;
    if (now - this.last < PAUSE) return;
    this.last = now;
    const tone = context.createOscillator();
    const volume = context.createGain();
    tone.frequency.setValueAtTime(PITCH, now);
    tone.frequency.exponentialRampToValueAtTime(PITCH / 3, now + LENGTH);
    volume.gain.setValueAtTime(0.4 * Math.min(Math.max(loudness, 0.05), 1), now);
    volume.gain.exponentialRampToValueAtTime(1e-3, now + LENGTH);
    tone.connect(volume).connect(context.destination);
    tone.start(now);
    tone.stop(now + LENGTH);
  }

  /** Give the sound card back. */
  close() {
    this.on = false;
    void this.context?.close();
    this.context = null;
  }
}
