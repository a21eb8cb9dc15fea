/** Angles as tones: an octave for each right angle from hanging, to the side where the ball is. */

import { fromBottom } from "./motion.js";

const HANGING = 220; // Hz
const VOLUME = 0.07;
// Pitch and side follow within so long, without steps that would be heard.
const FOLLOW = 0.008; // s
// A tone that is not followed any more ends by itself: after a pause, or in a hidden tab.
const HOLD = 0.12; // s
const FADE = 0.03; // s

/**
 * Return the pitch of an angle: 220 Hz for a ball that hangs, 440 Hz at 90 degrees, 880 Hz upright.
 * @param {number} angle [rad]
 */
export function pitchOf(angle) {
  return HANGING * 2 ** (fromBottom(angle) / (Math.PI / 2));
}

/** The tone of one ball. */
export class Tone {
  /**
   * @param {BaseAudioContext} context
   * @param {AudioNode} out
   */
  constructor(context, out) {
    this.context = context;
    this.source = new OscillatorNode(context, { type: "triangle", frequency: HANGING });
    this.volume = new GainNode(context, { gain: 0 });
    this.side = new StereoPannerNode(context);
    this.source.connect(this.volume).connect(this.side).connect(out);
    this.source.start();
  }

  /**
   * Sound as the ball is now.
   * @param {number} angle [rad]
   */
  follow(angle) {
    const { context, source, volume: { gain }, side } = this;
    const now = context.currentTime;
    source.frequency.setTargetAtTime(pitchOf(angle), now, FOLLOW);
    side.pan.setTargetAtTime(Math.sin(angle), now, FOLLOW);
    gain.cancelScheduledValues(now);
    gain.setTargetAtTime(VOLUME, now, FADE);
    gain.setTargetAtTime(0, now + HOLD, FADE);
  }
}
