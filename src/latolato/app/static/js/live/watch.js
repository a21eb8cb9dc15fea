/** The curves of a live toy: the last seconds of its angles and energies. */

import { History, SPAN } from "./motion.js";
import { Strip } from "./strip.js";

/** @typedef {import("./link.js").Frame} Frame */
/** @typedef {import("./motion.js").LiveMotion} LiveMotion */

const DEGREES = 180 / Math.PI;
const LEFT = { name: "left", paint: "left" };
const RIGHT = { name: "right", paint: "right" };
const ENERGIES = [{ name: "kinetic", paint: "kinetic" }, { name: "potential", paint: "potential" },
  { name: "total", paint: "ink" }];

export class Watch {
  /**
   * @param {HTMLCanvasElement} angle
   * @param {HTMLCanvasElement} energy
   */
  constructor(angle, energy) {
    this.history = new History(["right", "left", "kinetic", "potential", "total"]);
    this.angle = new Strip(angle, { least: [-15, 15], curves: [LEFT, RIGHT] });
    this.energy = new Strip(energy, { least: [0, 1e-6], curves: ENERGIES });
    this.angle.history = this.energy.history = this.history;
    this.contacts = 0;
  }

  /**
   * Begin with a toy.
   * @param {boolean} fresh whether nothing goes on from before
   * @param {boolean} single whether it has one ball
   */
  begin(fresh, single) {
    this.angle.marks = [];
    this.angle.curves = single ? [RIGHT] : [LEFT, RIGHT];
    if (!fresh) return;
    this.history.count = 0;
    this.contacts = 0;
    this.angle.limits = [...this.angle.least];
  }

  /**
   * Keep a frame.
   * @param {Frame} frame
   * @param {LiveMotion} motion
   * @param {boolean} clacks whether balls met audibly since the last one
   */
  add(frame, motion, clacks) {
    const [first, second] = motion.balls;
    this.history.add(frame.time, {
      right: motion.angle(first) * DEGREES,
      left: second ? motion.angle(second) * DEGREES : 0,
      kinetic: frame.kinetic_energy,
      potential: frame.potential_energy,
      total: frame.kinetic_energy + frame.potential_energy,
    });
    const { marks } = this.angle;
    if (frame.contacts < this.contacts) marks.length = 0;
    this.contacts = frame.contacts;
    if (!clacks) return;
    marks.push(frame.time);
    while (marks[0] < frame.time - SPAN) marks.shift();
  }

  /** Return the largest angle of the last seconds, either way [rad]. */
  largest() {
    const [lowest, highest] = this.history.range(["left", "right"]);
    return Math.max(-lowest, highest) / DEGREES;
  }

  draw() {
    this.angle.draw();
    this.energy.draw();
  }
}
