/** Lines along which the values of a map are equal, and round levels for them. */

import { InputError } from "../model/rules.js";
import { logTicks, ticks } from "../player/axis.js";
import { range } from "../player/motion.js";
import { t } from "../strings.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {{xs: Float64Array, ys: Float64Array}} ContourLine */

/** So many levels are drawn at a time. */
export const MOST_LEVELS = 20;
// A page can draw so many corners of lines.
const MOST_CORNERS = 2e6;
// About so many levels are chosen.
const USUAL = 6;
// A line that stays within fewer cells than this says nothing: a single point stands out.
const TINY = 2;
const FEW = 12; // points along a side

/**
 * Return about six round numbers between two values, the ends left out.
 * @param {number} low
 * @param {number} high
 * @param {number} size of the unit in which they are round
 * @param {boolean} log whether they are spaced evenly in their logarithm
 */
export function roundLevels(low, high, size, log) {
  const [first, last] = [low / size, high / size];
  if (!(first < last)) return [];
  const marks = log && first > 0 ? logTicks(first, last, USUAL).marks : ticks(first, last, USUAL);
  return marks.filter((mark) => first < mark && mark < last).map((mark) => mark * size);
}

/**
 * Return the lines of a map at some levels, and how many are left out that stay within two cells,
 * as single points of chaos have them; small maps keep these.
 *
 * Where only every second, fourth, ... row and column is complete, lines are those of that coarser
 * map. They end at points without an answer, and are straight between points; along a logarithmic
 * axis straight in the logarithm.
 * @param {Grid} grid
 * @param {number} variable its place
 * @param {number[]} levels
 * @returns {{lines: (ContourLine & {level: number})[], tiny: number}}
 */
export function linesOf(grid, variable, levels) {
  const stride = completeStride(grid);
  const every = (/** @type {Float64Array} */ values) => values.filter((_, i) => i % stride === 0);
  const [x, y] = [every(grid.x.values), every(grid.y.values)];
  if (Math.min(x.length, y.length) < 2) return { lines: [], tiny: 0 };
  const values = grid.values[variable].filter((_, at) =>
    (at % grid.width) % stride === 0 && Math.floor(at / grid.width) % stride === 0);
  const all = levels.flatMap((level) =>
    linesAt(values, x.length, level).map(({ xs, ys }) => ({ level, xs, ys })));
  if (all.reduce((sum, { xs }) => sum + xs.length, 0) > MOST_CORNERS)
    throw new InputError(t("refuseCorners"));
  const isSmall = Math.min(x.length, y.length) < FEW;
  const kept = all.filter(({ xs, ys }) => isSmall || Math.max(extent(xs), extent(ys)) >= TINY);
  return { tiny: all.length - kept.length, lines: kept.map(({ level, xs, ys }) => ({ level,
    xs: xs.map((place) => valueAtPlace(x, place, grid.x.log)),
    ys: ys.map((place) => valueAtPlace(y, place, grid.y.log)) })) };
}

/**
 * Return the smallest power of two whose multiples are rows and columns that are all known.
 * @param {Grid} grid
 */
function completeStride(grid) {
  const { width, height } = grid;
  let stride = 1;
  const isKnown = () => {
    for (let row = 0; row < height; row += stride)
      for (let column = 0; column < width; column += stride) {
        const at = row * width + column;
        if (!grid.isKnown(at) || grid.lack(at, 0) === "notYet") return false;
      }
    return true;
  };
  while (stride < Math.max(width, height) && !isKnown()) stride *= 2;
  return stride;
}

/**
 * Return the difference of the largest and the least of some numbers.
 * @param {Float64Array} numbers
 */
function extent(numbers) {
  const [low, high] = range(numbers);
  return high - low;
}

/**
 * Return the value at a place among the points of an axis.
 * @param {Float64Array} values
 * @param {number} place
 * @param {boolean} log
 */
function valueAtPlace(values, place, log) {
  const i = Math.min(Math.floor(place), values.length - 2);
  const [a, b] = [values[i], values[i + 1]];
  return log ? a * (b / a) ** (place - i) : a + (b - a) * (place - i);
}

/**
 * Return the lines of a level over points of rows and columns, in numbers of these: marching squares,
 * with triangles where one corner of a cell has no value.
 * @param {ArrayLike<number>} values row by row
 * @param {number} width
 * @param {number} level
 * @returns {ContourLine[]}
 */
export function linesAt(values, width, level) {
  const above = new Uint8Array(values.length);
  for (let at = 0; at < above.length; at += 1) above[at] = Number(values[at] > level);
  const crossings = new Crossings(values, width, level);
  for (let low = 0; low + width < values.length; low += 1) {
    if (low % width === width - 1) continue;
    const count = above[low] + above[low + 1] + above[low + width] + above[low + width + 1];
    if (count === 0 || count === 4) continue;
    const around = [low, low + 1, low + width + 1, low + width]
      .filter((at) => Number.isFinite(values[at]));
    if (around.length < 3) continue;
    const ends = [];
    for (let i = 0, at = around[around.length - 1]; i < around.length; at = around[i], i += 1)
      if (above[at] !== above[around[i]]) ends.push(crossings.between(at, around[i]));
    const [p, q, r, s] = ends;
    if (ends.length === 2) crossings.join(p, q);
    if (ends.length < 4) continue;
    // Of a saddle the middle decides which two corners are one side.
    const middle = around.reduce((sum, at) => sum + values[at], 0) / 4;
    const isCut = (middle > level) === (above[low] === 1);
    for (const [one, other] of isCut ? [[q, r], [s, p]] : [[p, q], [r, s]])
      crossings.join(one, other);
  }
  return crossings.lines();
}

/** Where the sides of cells have a level, and which of these places a line joins. */
class Crossings {
  /**
   * @param {ArrayLike<number>} values
   * @param {number} width
   * @param {number} level
   */
  constructor(values, width, level) {
    this.values = values;
    this.width = width;
    this.level = level;
    // Their numbers by point and direction: to the right, upwards, on both diagonals.
    this.numbers = new Int32Array(4 * values.length).fill(-1);
    /** @type {number[]} */
    this.xs = [];
    /** @type {number[]} */
    this.ys = [];
    /** @type {number[]} two places for each, -1 for none */
    this.joined = [];
  }

  /**
   * Return the number of the crossing between two points.
   * @param {number} one
   * @param {number} other
   */
  between(one, other) {
    const { values, width, level, numbers, xs, ys } = this;
    const [a, b] = one < other ? [one, other] : [other, one];
    const column = a % width;
    const right = b % width - column;
    const up = Math.floor(b / width) - Math.floor(a / width);
    const place = 4 * a + (up === 0 ? 0 : right + 2);
    if (numbers[place] < 0) {
      numbers[place] = xs.length;
      const share = (level - values[a]) / (values[b] - values[a]);
      xs.push(column + share * right);
      ys.push(Math.floor(a / width) + share * up);
      this.joined.push(-1, -1);
    }
    return numbers[place];
  }

  /**
   * @param {number} one
   * @param {number} other
   */
  join(one, other) {
    const { joined } = this;
    joined[2 * one + (joined[2 * one] < 0 ? 0 : 1)] = other;
    joined[2 * other + (joined[2 * other] < 0 ? 0 : 1)] = one;
  }

  /**
   * Return the lines; a ring ends where it begins.
   * @returns {ContourLine[]}
   */
  lines() {
    const { xs, ys, joined } = this;
    const seen = new Uint8Array(xs.length);
    const lines = [];
    const all = [...xs.keys()];
    for (const start of [...all.filter((at) => joined[2 * at + 1] < 0), ...all]) {
      if (seen[start]) continue;
      const line = [];
      for (let at = start; at >= 0 && !seen[at];) {
        seen[at] = 1;
        line.push(at);
        at = joined[2 * at] >= 0 && !seen[joined[2 * at]] ? joined[2 * at] : joined[2 * at + 1];
      }
      if (joined[2 * start + 1] >= 0) line.push(start);
      lines.push({ xs: Float64Array.from(line, (at) => xs[at]),
        ys: Float64Array.from(line, (at) => ys[at]) });
    }
    return lines;
  }
}
