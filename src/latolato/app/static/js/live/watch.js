/** The curves of a live toy: the last seconds of its angles and energies. */

import { History, SPAN } from "./motion.js";
import { Strip } from "./strip.js";

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
    this.history = new History(["right", "left", "pivot", "kinetic", "potential", "total"]);
    this.angle = new Strip(angle, { least: [-15, 15], curves: [LEFT, RIGHT] });
    this.energy = new Strip(energy, { least: [0, 1e-6], curves: ENERGIES });
    this.angle.history = this.energy.history = this.history;
    this.turn = false;
  }

  /**
   * Begin with a toy.
   * @param {boolean} single whether it has one ball
   */
  begin(single) {
    this.angle.marks = [];
    this.angle.curves = single ? [RIGHT] : [LEFT, RIGHT];
    this.history.count = 0;
    this.angle.limits = [...this.angle.least];
  }

  /**
   * Keep what a toy does now.
   * @param {LiveMotion} motion
   * @param {boolean} clacks whether balls met audibly since the last time
   */
  add(motion, clacks) {
    const [first, second] = motion.balls;
    const { time, energies: { kinetic, potential } } = motion.toy;
    this.history.add(time, {
      right: motion.angle(first) * DEGREES,
      left: second ? motion.angle(second) * DEGREES : 0,
      pivot: motion.toy.pivot.height, kinetic, potential, total: kinetic + potential,
    });
    if (!clacks) return;
    const { marks } = this.angle;
    marks.push(time);
    while (marks[0] < time - SPAN) marks.shift();
  }

  /** Return the largest angle of the last seconds, either way [rad]. */
  largest() {
    const [lowest, highest] = this.history.range(["left", "right"]);
    return Math.max(-lowest, highest) / DEGREES;
  }

  /**
   * Draw the curves: of a toy that moves one strip with each picture, in turn, which is half the work.
   * @param {boolean} both
   */
  draw(both) {
    this.turn = !this.turn;
    if (both || this.turn) this.angle.draw();
    if (both || !this.turn) this.energy.draw();
  }
}
