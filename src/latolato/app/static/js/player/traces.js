/** Curves as a chart draws them: what it is given, and the path through it. */

import UPlot from "../../vendor/uPlot.js";
import { before, range } from "./motion.js";

/** @typedef {import("./motion.js").Motion} Motion */
/**
 * A curve; one whose values jump by `turn` where they are one turn on is not drawn through that.
 * `ofPose` returns its value where the balls are on show.
 * @typedef {{label: string, paint: string, dash?: number[], values: ArrayLike<number>, turn?: number,
 *   axis?: "right", ofPose?: (pose: import("./motion.js").Pose) => number}} Curve
 */

// A swing narrower than this is no longer drawn as a line [pixels].
const NARROW = 3;
const LINE = /** @type {any} */ (UPlot.paths).linear();

/**
 * Return the path of a curve: a line, or a band where swings are narrower than pixels.
 * @param {any} u
 * @param {number} k
 * @param {number} i0
 * @param {number} i1
 * @param {number} period of a swing
 */
export function pathOf(u, k, i0, i1, period) {
  const position = (/** @type {number} */ x) => u.valToPos(x, "x", true);
  const pixels = position(1) - position(0);
  if (!isDense(period, pixels)) return LINE(u, k, i0, i1);
  const { scale } = u.series[k];
  const { first, low, high } = envelope(u.data[0], u.data[k], i0, i1, position, period);
  const stroke = new Path2D();
  for (let i = 0; i < low.length; i += 1) {
    if (low[i] > high[i]) continue;
    const x = first + i + 0.5;
    const top = u.valToPos(high[i], scale, true);
    stroke.moveTo(x, top);
    stroke.lineTo(x, Math.max(u.valToPos(low[i], scale, true), top + 1));
  }
  return { stroke, fill: null, clip: null, gaps: null, flags: 0 };
}

/**
 * Return what a pen of one pixel would leave of a dense curve, without false beats: the least and the
 * largest value around every pixel column, of the samples within half a
 * `period` to both sides, so that a column never shows a part of a swing only.
 * @param {ArrayLike<number>} xs increasing
 * @param {ArrayLike<number>} ys
 * @param {number} from first sample
 * @param {number} to last sample
 * @param {(x: number) => number} position pixel of a value of x
 * @param {number} period in units of x
 */
export function envelope(xs, ys, from, to, position, period) {
  const first = Math.floor(position(xs[from]));
  const count = Math.max(1, Math.floor(position(xs[to])) - first + 1);
  const low = new Float64Array(count).fill(Infinity);
  const high = new Float64Array(count).fill(-Infinity);
  const offset = position(0);
  const slope = position(1) - offset;
  for (let i = from; i <= to; i += 1) {
    const y = ys[i];
    if (y !== y || y === null) continue;
    let k = Math.floor(offset + slope * xs[i]) - first;
    if (k < 0) k = 0;
    else if (k >= count) k = count - 1;
    if (y < low[k]) low[k] = y;
    if (y > high[k]) high[k] = y;
  }
  const reach = Math.ceil(0.5 * period * slope);
  return { first, low: slide(low, reach, Math.min), high: slide(high, reach, Math.max) };
}

/**
 * Return the extreme of each value and its neighbours up to `reach` away.
 * @param {Float64Array} values
 * @param {number} reach
 * @param {(a: number, b: number) => number} extreme
 */
function slide(values, reach, extreme) {
  if (reach < 1) return values;
  const result = new Float64Array(values.length);
  for (let i = 0; i < values.length; i += 1) {
    let best = values[i];
    for (let k = Math.max(0, i - reach); k <= Math.min(values.length - 1, i + reach); k += 1)
      best = extreme(best, values[k]);
    result[i] = best;
  }
  return result;
}

/**
 * Return whether swings of this period are too narrow to be drawn as a line.
 * @param {number} period in units of x
 * @param {number} pixels pixels of a unit of x
 */
export function isDense(period, pixels) {
  return period * pixels < NARROW;
}

/**
 * Return the least and the largest of two values and all on the left axis up to an instant.
 * @param {any} u
 * @param {number} low
 * @param {number} high
 * @param {number} until
 * @returns {[number, number]}
 */
export function extremesUntil({ data, series }, low, high, until) {
  const ends = series.flatMap((/** @type {any} */ { scale }, /** @type {number} */ k) =>
    (scale === "y" ? range(data[k], 0, before(data[0], until) + 1) : []));
  return [Math.min(low, ...ends), Math.max(high, ...ends)];
}

/**
 * @param {Motion | null} motion
 * @param {Curve[]} curves
 * @returns {any}
 */
export function dataOf(motion, curves) {
  return [motion?.time ?? [0], ...curves.map(drawn)];
}

/**
 * Return values as the chart takes them: null where they are not finite, or one turn on.
 * @param {Curve} curve
 */
function drawn({ values, turn = Infinity }) {
  const isDrawn = (/** @type {number} */ i) => Number.isFinite(values[i])
    && !(Math.abs(values[i] - values[i - 1]) > 0.5 * turn);
  for (let i = 0; i < values.length; i += 1)
    if (!isDrawn(i)) return Array.from(values, (value, k) => (isDrawn(k) ? value : null));
  return values;
}

/**
 * Return the value at an instant, linear between samples, NaN beside one that is unknown.
 * @param {ArrayLike<number>} times
 * @param {ArrayLike<number>} values
 * @param {number} time
 */
export function valueAt(times, values, time) {
  const i = Math.max(Math.min(before(times, time), times.length - 2), 0);
  const [one, other] = [values[i] ?? NaN, values[i + 1] ?? NaN];
  return time === times[i] ? one : resampled([times[i], times[i + 1]], [one, other], [time])[0];
}

/**
 * Return values at other instants, linear between samples, NaN beyond the last.
 * @param {ArrayLike<number>} times
 * @param {ArrayLike<number>} values
 * @param {ArrayLike<number>} instants
 */
export function resampled(times, values, instants) {
  const result = new Float64Array(instants.length);
  let i = 0;
  for (let k = 0; k < instants.length; k += 1) {
    while (i < times.length - 2 && times[i + 1] < instants[k]) i += 1;
    const share = (instants[k] - times[i]) / (times[i + 1] - times[i]);
    result[k] = share > 1 ? NaN : values[i] + share * (values[i + 1] - values[i]);
  }
  return result;
}

/**
 * Return values times a number.
 * @param {ArrayLike<number>} values
 * @param {number} by
 */
export function scaled(values, by) {
  const result = new Float64Array(values.length);
  for (let i = 0; i < values.length; i += 1) result[i] = values[i] * by;
  return result;
}
