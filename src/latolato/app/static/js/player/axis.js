/** Axes: limits that can be drawn, and round numbers between them. */

import { localShort } from "../page/unit_text.js";

/** Values that differ by less than this share of their size differ by rounding only. */
export const ROUNDING = 1e-9;
/** The same for samples that come in single precision. */
export const SINGLE = 1e-6;
// A single value gets this share of itself as room on both sides.
const ROOM = 0.05;
// Sizes that leave room for arithmetic.
const [LEAST, MOST] = [1e-300, 1e300];
const LEAST_MARKS = 3;

/**
 * Return limits of an axis that hold two values: finite, rising, and further apart than by
 * rounding. A value that is not finite counts for nothing.
 * @param {number} low
 * @param {number} high
 * @param {number} [rounding] share of their size by which values differ without meaning
 * @returns {[number, number]}
 */
export function axisLimits(low, high, rounding = ROUNDING) {
  const ends = [low, high].filter(Number.isFinite)
    .map((end) => Math.min(Math.max(end, -MOST), MOST));
  if (!ends.length) return [-1, 1];
  const [from, to] = [Math.min(...ends), Math.max(...ends)];
  if (to - from > Math.max(rounding * Math.max(-from, to), LEAST)) return [from, to];
  const middle = 0.5 * (from + to);
  const room = ROOM * Math.abs(middle);
  return room > LEAST ? [middle - room, middle + room] : [-1, 1];
}

/**
 * Return round numbers between two, about `count` of them; of two that agree but for rounding the
 * first, as it is.
 * @param {number} low
 * @param {number} high
 * @param {number} [count]
 * @returns {number[]}
 */
export function ticks(low, high, count = 5) {
  const [from, to] = axisLimits(low, high);
  if (from !== low || to !== high) return Number.isFinite(low) ? [low] : [];
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const steps = [0.2, 0.5, 1, 2, 5, 10].map((k) => k * power);
  // The step that is asked for, or a finer one if that left less than three marks.
  for (let i = steps.findIndex((s) => s >= rough * (1 - 1e-9)); ; i -= 1) {
    const step = steps[i];
    const marks = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1)
      marks.push(Math.abs(k) < 1e-9 ? 0 : k * step);
    if (marks.length >= LEAST_MARKS || i === 0) return marks;
  }
}

/**
 * Return the marks of a logarithmic axis: about `count` powers of ten that get a number, or their
 * doubles and halves too where powers are few, and small marks at whole multiples of powers. Where
 * less than two would get a number, these are round numbers.
 * @param {number} low
 * @param {number} high
 * @param {number} [count]
 */
export function logTicks(low, high, count = 5) {
  const decades = Math.log10(high / low);
  const multiples = (/** @type {number[]} */ digits, step = 1) => {
    const found = [];
    for (let k = Math.floor(Math.log10(low)); k <= Math.log10(high) + ROUNDING; k += 1)
      if (k % step === 0) found.push(...digits.map((digit) => digit * 10 ** k));
    return found.filter((mark) => mark >= low * (1 - ROUNDING) && mark <= high * (1 + ROUNDING));
  };
  const marks = low > 0 ? multiples(decades < 3 ? [1, 2, 5] : [1], Math.max(1, Math.round(decades / count))) : [];
  if (marks.length < 2) return { marks: ticks(low, high, count), small: [] };
  return { marks, small: decades > 4 ? [] : multiples([1, 2, 3, 4, 5, 6, 7, 8, 9]) };
}

/**
 * Return settings of an axis of uPlot: at least three marks, about so many pixels of the page apart.
 * @param {"width" | "height"} along
 * @param {number} every
 */
export function marksOf(along, every) {
  return {
    // The size that uPlot keeps: asking the page for it would lay it out in every frame.
    splits: (/** @type {any} */ { bbox }, /** @type {number} */ _, /** @type {number} */ low,
      /** @type {number} */ high) => ticks(low, high,
      Math.max(Math.round(bbox[along] / devicePixelRatio / every), 2)),
    values: (/** @type {any} */ _, /** @type {number[]} */ marks) => marks.map((mark) => localShort(mark, 4)),
  };
}

/** Settings of an upright axis of uPlot: its width and its marks. */
export const UPRIGHT = { size: 58, ...marksOf("height", 30) };
