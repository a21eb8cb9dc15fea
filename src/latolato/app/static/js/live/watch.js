/** The curves of a live toy: the last seconds of its angles and energies. */

import { curvesOf } from "../shared/describe.js";
import { isBehind } from "../shared/instant.js";
import { inText } from "../shared/narrator.js";
import { DEGREE, localShort } from "../shared/units.js";
import { History, SPAN } from "./motion.js";
import { Strip } from "./strip.js";

/** @typedef {import("./motion.js").LiveMotion} LiveMotion */
/** @typedef {{canvas: HTMLCanvasElement, values: Record<string, HTMLElement>}} Place */

const DIGITS = 4;
const LEFT = { name: "left", paint: "left" };
const RIGHT = { name: "right", paint: "right" };
const ENERGIES = [{ name: "kinetic", paint: "kinetic" }, { name: "potential", paint: "potential" },
  { name: "total", paint: "ink" }];

export class Watch {
  /**
   * @param {Place} angle
   * @param {Place} energy
   */
  constructor(angle, energy) {
    this.history = new History(["right", "left", "far", "other", "pivot", "kinetic", "potential",
      "total"]);
    this.angle = new Strip(angle.canvas, { least: [-15, 15], curves: [LEFT, RIGHT] });
    this.energy = new Strip(energy.canvas, { least: [0, 1e-6], curves: ENERGIES });
    this.angle.history = this.energy.history = this.history;
    this.labels = [{ strip: this.angle, quantity: "angle" }, { strip: this.energy, quantity: "energy" }]
      .map((each) => ({ ...each, label: each.strip.canvas.getAttribute("aria-label") }));
    this.values = { ...angle.values, ...energy.values };
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
    const { time } = motion.toy;
    this.history.add(time, valuesOf(motion));
    if (!clacks) return;
    const { marks } = this.angle;
    marks.push(time);
    while (marks[0] < time - SPAN) marks.shift();
  }

  /**
   * Write what a toy does now into the legends, but for numbers that would be behind the picture.
   * @param {LiveMotion} motion
   * @param {number} lag how far they may be behind [s of the toy]
   */
  read(motion, lag) {
    const now = valuesOf(motion);
    const period = (2 * Math.PI) / motion.naturalFrequency;
    for (const [name, output] of Object.entries(this.values)) {
      const [low, high] = this.history.range([name], period);
      const text = isBehind(low, high, period, lag) ? "" : localShort(now[name], DIGITS);
      if (output.textContent !== text) output.textContent = text;
    }
  }

  /** Say in words what the curves show. */
  describe() {
    const { history } = this;
    if (history.count < 2) return;
    const inOrder = (/** @type {Float64Array} */ values) =>
      Float64Array.from({ length: history.count }, (_, k) => values[history.at(k)]);
    for (const { strip, quantity, label } of this.labels) {
      const curves = strip.curves.map(({ name }) => inOrder(history.values[name]));
      const text = inText(curvesOf(quantity, inOrder(history.time), curves));
      strip.canvas.setAttribute("aria-label", `${label}. ${text}`);
    }
  }

  /** Return the largest angle of the last seconds, either way [rad]. */
  largest() {
    const [lowest, highest] = this.history.range(["left", "right"]);
    return Math.max(-lowest, highest) * DEGREE;
  }

  /**
   * Draw the curves: of a toy that moves one strip with each picture, in turn, which is half the work.
   * @param {boolean} both
   * @param {boolean} hasEnergy whether energies are to be seen
   */
  draw(both, hasEnergy) {
    this.turn = !this.turn;
    if (both || this.turn) this.angle.draw();
    if (hasEnergy && (both || !this.turn)) this.energy.draw();
  }
}

/**
 * The present values of the curves by name: angles in degrees, the rest in SI units.
 * @param {LiveMotion} motion
 * @returns {Record<string, number>}
 */
function valuesOf(motion) {
  const [first, second] = motion.balls;
  const { kinetic, potential } = motion.toy.energies;
  return { right: motion.angle(first) / DEGREE, left: second ? motion.angle(second) / DEGREE : 0,
    far: motion.distance(first), other: motion.distance(second ?? first), pivot: motion.toy.pivot.height, kinetic, potential, total: kinetic + potential };
}
