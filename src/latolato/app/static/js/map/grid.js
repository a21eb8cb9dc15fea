/** The cells of a map: what is known of each, and where they lie. */

import { axisLimits, SINGLE } from "../shared/axis.js";
import { row } from "../shared/block.js";

/** @typedef {import("../shared/block.js").Block} Block */
/** @typedef {{name: string, label: string, symbol: string, unit: string, log?: boolean,
 *   units: {name: string, size: number}[], allowed?: (number | null)[],
 *   suggested?: [number, number]}} Axis */
/** @typedef {{name: string, ball: string | null, label: string, symbol: string, unit: string,
 *   units: {name: string, size: number}[], classes: [string, string][]}} Variable */

const NOT_YET = 255;
/** Statuses from this number on say that there is no answer (`latolato.numerics.records`). */
const FIRST_BAD = 3;

/**
 * Return the number of the cell between whose borders a value lies, -1 outside.
 * @param {ArrayLike<number>} edges increasing
 * @param {number} value
 */
export function cellAt(edges, value) {
  if (!(value >= edges[0] && value <= edges[edges.length - 1])) return -1;
  let low = 0;
  let high = edges.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (edges[middle] <= value) low = middle;
    else high = middle;
  }
  return low;
}

export class Grid {
  /** @param {Block} begin the frame that a map begins with */
  constructor(begin) {
    this.about = begin.about;
    /** @type {Axis} */
    this.xAxis = begin.about.x;
    /** @type {Axis} */
    this.yAxis = begin.about.y;
    /** @type {Variable[]} */
    this.variables = begin.about.variables;
    this.x = /** @type {Float64Array} */ (begin.arrays.x);
    this.y = /** @type {Float64Array} */ (begin.arrays.y);
    this.xEdges = /** @type {Float64Array} */ (begin.arrays.x_edges);
    this.yEdges = /** @type {Float64Array} */ (begin.arrays.y_edges);
    this.width = this.x.length;
    this.height = this.y.length;
    const count = this.width * this.height;
    this.values = this.variables.map(() => new Float32Array(count).fill(NaN));
    this.status = new Uint8Array(count).fill(NOT_YET);
    // How coarse the point is that a cell has its colour from; 1 is its own.
    this.stride = new Uint8Array(count).fill(NOT_YET);
    this.done = 0;
    this.complete = false;
  }

  /**
   * Take in cells: a coarse point also colours the cells about it until they have their own.
   * @param {Block} block
   */
  put(block) {
    const { cell, stride, status } = block.arrays;
    const rows = this.values.map((_, k) => row(block, "values", k));
    for (let i = 0; i < cell.length; i += 1) {
      const s = stride[i];
      const middleRow = Math.floor(cell[i] / this.width);
      const middleColumn = cell[i] % this.width;
      const half = s >> 1;
      const top = Math.min(middleRow + Math.max(half, 1), this.height);
      const right = Math.min(middleColumn + Math.max(half, 1), this.width);
      for (let r = Math.max(0, middleRow - half); r < top; r += 1)
        for (let c = Math.max(0, middleColumn - half); c < right; c += 1) {
          const at = r * this.width + c;
          const own = at === cell[i];
          if (!own && this.stride[at] <= s) continue;
          this.stride[at] = own ? 1 : s;
          this.status[at] = status[i];
          for (let k = 0; k < rows.length; k += 1) this.values[k][at] = rows[k][i];
        }
    }
    this.done = block.about.points;
  }

  /**
   * Return the place of a variable among those that the cells have, -1 if they have it not.
   * @param {string} name
   * @param {string | null} [ball]
   */
  variable(name, ball = null) {
    const fits = (/** @type {Variable} */ v) => v.name === name && (!ball || v.ball === ball);
    return this.variables.findIndex(fits);
  }

  /**
   * Return what is known of a cell: its value, or why there is none.
   * @param {number} at
   * @param {number} k place of the variable
   * @returns {{value: number, why: "" | "notYet" | "noAnswer" | "noValue", status: string,
   *   exact: boolean}}
   */
  tell(at, k) {
    const status = this.status[at];
    const value = this.values[k]?.[at] ?? NaN;
    const name = this.about.statuses?.[status] ?? "";
    const exact = this.stride[at] === 1;
    if (status === NOT_YET) return { value: NaN, why: "notYet", status: "", exact };
    if (status >= FIRST_BAD) return { value: NaN, why: "noAnswer", status: name, exact };
    return { value, why: Number.isNaN(value) ? "noValue" : "", status: name, exact };
  }

  /** Return the share of the cells that are known. */
  share() {
    return 1 - (this.about.points - this.done) / (this.width * this.height);
  }

  /** Return how many cells have no answer. */
  withoutAnswer() {
    return this.status.reduce((n, s) => n + (s >= FIRST_BAD && s !== NOT_YET ? 1 : 0), 0);
  }

  /**
   * Return the least and the largest value of a variable, above zero only for a log scale.
   * @param {number} k
   * @param {boolean} [positive]
   * @returns {[number, number]}
   */
  range(k, positive = false) {
    let low = Infinity;
    let high = -Infinity;
    const values = this.values[k] ?? [];
    for (let i = 0; i < values.length; i += 1) {
      const value = values[i];
      if (!Number.isFinite(value) || (positive && value <= 0)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    if (!(low <= high)) return positive ? [0.1, 1] : [0, 1];
    return axisLimits(low, high, SINGLE);
  }
}
