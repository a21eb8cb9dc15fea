/** A tracked video as the page knows it: angles, places in the picture and flags of every frame. */

import { row } from "../page/block.js";
import { DEGREE } from "../page/unit_text.js";
import { t } from "../strings.js";

/** @typedef {import("../page/block.js").Block} Block */
/** @typedef {import("../player/curves.js").Panel} Panel */
/** @typedef {import("../player/curves.js").Curve} Curve */
/** @typedef {import("../player/curve_chart.js").Shade} Shade */

const GRAVITY = 9.8; // only to tell dense curves from others
export const SIDES = ["right", "left"];
/** How the times without a sample are painted, as those of a ball that was not seen. */
const GAP = "flag-lost";

export class Track {
  /** @param {Block} block */
  constructor(block) {
    this.block = block;
    const { about, arrays } = block;
    this.count = about.balls;
    /** Number in the file of the first frame. */
    this.firstFrame = about.first_frame;
    this.width = about.width;
    this.height = about.height;
    /** @type {string[]} */
    this.flags = about.flags;
    const clock = /** @type {Float64Array} */ (arrays.time);
    this.first = clock[0];
    this.time = clock.map((s) => s - clock[0]);
    this.media = /** @type {Float64Array} */ (arrays.media_time);
    this.end = this.time[this.time.length - 1];
    /** Samples before which others are missing. @type {number[]} */
    this.afterGaps = about.after_gaps;
    this.radius = about.attributes.radius_pixels ?? 8;
    this.hasAngles = about.attributes.geometry !== "unknown";
    this.about = { attributes: {
      natural_frequency: Math.sqrt(GRAVITY / (about.attributes.length ?? 0.3)) } };
    /** @type {Block | null} */
    this.model = null;
    this.isDriven = false;
  }

  /** Return the balls; their names tell charts which curves there are. */
  get balls() {
    return Array.from({ length: this.count }, (_, b) => ({
      name: [SIDES[b], this.hasAngles, this.model?.about.balls, this.isDriven].join() }));
  }

  /**
   * Return one quantity over the frames.
   * @param {string} name
   * @param {number} ball
   */
  values(name, ball) {
    return row(this.block, name, ball);
  }

  /**
   * Return the flag of a ball in a frame.
   * @param {number} frame
   * @param {number} ball
   */
  flag(frame, ball) {
    return this.flags[this.values("flag", ball)[frame]];
  }

  /**
   * Return pivot and balls of a frame in the picture [pixels], where a camera that moved shows them.
   * @param {number} frame
   */
  places(frame) {
    const [a, b, c, d, e, f] = this.block.arrays.motion
      ? Array.from({ length: 6 }, (_, k) => this.values("motion", k)[frame]) : [1, 0, 0, 0, 1, 0];
    const place = (/** @type {Block} */ block, /** @type {string} */ name,
      /** @type {number} */ k) => {
      const [u, v] = [row(block, name, 2 * k)[frame], row(block, name, 2 * k + 1)[frame]];
      return { u: a * u + b * v + c, v: d * u + e * v + f };
    };
    const balls = Array.from({ length: this.count }, (_, b) => place(this.block, "centre", b));
    const { model } = this;
    const ghosts = model
      ? Array.from({ length: model.about.balls }, (_, b) => place(model, "centre", b)) : [];
    return { pivot: place(this.block, "pivot", 0), balls, ghosts };
  }

  /**
   * Return the stretches of time in which a ball was not plainly seen.
   * @returns {Shade[]}
   */
  shades() {
    const { time } = this;
    /** @type {Shade[]} */
    const spans = this.afterGaps.map((k) => ({ from: time[k - 1], to: time[k], paint: GAP }));
    for (let b = 0; b < this.count; b += 1) {
      const codes = this.values("flag", b);
      for (let i = 0; i < codes.length; i += 1) {
        if (codes[i] === 0) continue;
        let k = i;
        while (k + 1 < codes.length && codes[k + 1] === codes[i]) k += 1;
        const half = 0.5 * (time[1] - time[0]);
        spans.push({ from: time[i] - half, to: time[k] + half,
          paint: `flag-${this.flags[codes[i]]}` });
        i = k;
      }
    }
    return spans;
  }

  /**
   * Return how many samples have each flag, those that occur.
   * @returns {{flag: string, count: number}[]}
   */
  counts() {
    const codes = Array.from(this.block.arrays.flag);
    return this.flags.map((flag, code) => ({
      flag, count: codes.filter((each) => each === code).length }))
      .filter(({ count }) => count > 0);
  }

  /**
   * Return values times a number as a curve, null where they are unknown; no line is drawn over a gap.
   * @param {ArrayLike<number>} values
   * @returns {any}
   */
  curve(values, by = 1) {
    const shown = Array.from(values, (v) => (Number.isFinite(v) ? v * by : null));
    for (const k of this.afterGaps) shown[k] = null;
    return shown;
  }

  /**
   * @param {(ball: number) => ArrayLike<number>} values
   * @param {number} [by]
   * @returns {Curve[]}
   */
  perBall(values, by) {
    return Array.from({ length: this.count }, (_, b) => ({
      label: this.count > 1 ? t(SIDES[b]) : t("measured"), paint: SIDES[b], values: this.curve(values(b), by) }));
  }

  /** @returns {Curve[]} */
  modelCurves() {
    const { model } = this;
    if (!model) return [];
    return Array.from({ length: model.about.balls }, (_, b) => ({
      label: b ? t("modelLeft") : t("model"), paint: "model", dash: [6, 4],
      values: this.curve(row(model, "angle", b), 1 / DEGREE) }));
  }

  /**
   * Return measured minus computed angle [mrad] where the ball was plainly seen.
   * @param {number} b
   */
  residual(b) {
    const model = /** @type {Block} */ (this.model);
    if (b >= model.about.balls) return [];
    const one = this.values("angle", b);
    const other = row(model, "angle", b);
    const codes = this.values("flag", b);
    return one.map((v, i) => (codes[i] === 0 ? 1000 * (v - other[i]) : NaN));
  }
}

/**
 * Return the panels of curves for a clip; they draw whichever clip is on show.
 * @param {Track} track
 * @returns {Panel[]}
 */
export function panelsOf(track) {
  const of = (/** @type {any} */ motion) => /** @type {Track} */ (motion);
  const shades = (/** @type {any} */ motion) => of(motion).shades();
  const hasGaps = track.shades().some(({ paint }) => paint === GAP);
  const label = (/** @type {string} */ name) => (hasGaps ? t("curveWithGaps", { text: t(name) }) : t(name));
  if (!track.hasAngles) {
    return [{ label: label("curvePlace"), height: 230, shades, curves: (motion) =>
      of(motion).perBall((b) => of(motion).values("centre", 2 * b)) }];
  }
  /** @type {Panel[]} */
  const panels = [{ label: label("curveAngle"), height: 230, shades, curves: (motion) => [
    ...of(motion).perBall((b) => of(motion).values("angle", b), 1 / DEGREE),
    ...of(motion).modelCurves(),
  ] }];
  if (track.model) {
    panels.push({ label: label("curveResidual"), height: 140, shades, curves: (motion) =>
      of(motion).perBall((b) => of(motion).residual(b)).slice(0, of(motion).model?.about.balls) });
  }
  if (track.isDriven) {
    panels.push({ label: t("curvePivot"), height: 140, curves: (motion) => [{
      label: t("pivot"), paint: "ink",
      values: of(motion).curve(of(motion).values("pivot_height", 0), 1000) }] });
  }
  return panels;
}
