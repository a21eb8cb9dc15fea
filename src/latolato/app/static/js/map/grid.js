/** The cells of a map: what is known of each, and where they lie. */

import { axisLimits, SINGLE } from "../player/axis.js";
import { before, range } from "../player/motion.js";

/**
 * What a map is of: `parameters` are those of the system that do not vary [SI], by their names, and
 * `laws` all that system and drive are of.
 * @typedef {{observable: string, title: string, statuses: string[], variables: Variable[],
 *   parameters: Record<string, number>, laws: Record<string, any>, has_contact: boolean, python: string,
 *   command: string, stored?: Stored}} MapAbout
 *
 * An axis: what varies along it, and the middles and borders of its cells [SI].
 * @typedef {{name: string, label: string, symbol: string, unit: string, log: boolean,
 *   units: {name: string, size: number}[], allowed?: (number | null)[],
 *   values: Float64Array, edges: Float64Array}} Axis
 *
 * The metadata of a stored map: the variables that it has, further dimensions with the value that is
 * taken, points that are not computed, and what its points run with [SI]: options, the values of all
 * parameters that vary along its axes, those that are taken of others, and random streams as sums of
 * two numbers. Without options its points cannot run alone, for a reason.
 * @typedef {{names: string[], select: any[], missing: number, description: string,
 *   options: Record<string, any> | null, reason: string,
 *   sets: Record<"x" | "y", Record<string, number[]>> & {all: Record<string, number>},
 *   streams: Record<"x" | "y", number[]> | null}} Stored
 *
 * Cells as they come: `values` has a row for each variable.
 * @typedef {{cell: Int32Array, stride: Uint8Array, status: ArrayLike<number>,
 *   values: ArrayLike<number>[]}} Cells
 */
/** @typedef {{name: string, ball: string | null, label: string, symbol: string, unit: string,
 *   units: {name: string, size: number}[], classes: [string, string][], log?: boolean,
 *   scale?: string, words: import("./class_words.js").Words}} Variable `log` and `scale` are the usual
 *   colours */

/** The status of a cell whose point is not computed. */
export const NOT_YET = 255;
/** Statuses from this number on say that there is no answer (`latolato.numerics.records`). */
const FIRST_BAD = 3;

/**
 * Return the number of the cell between whose borders a value lies, -1 outside.
 * @param {ArrayLike<number>} edges increasing
 * @param {number} value
 */
export function cellAt(edges, value) {
  if (!(value >= edges[0] && value <= edges[edges.length - 1])) return -1;
  return Math.min(before(edges, value), edges.length - 2);
}

export class Grid {
  /**
   * @param {MapAbout} about
   * @param {Axis} x
   * @param {Axis} y
   * @param {(cell: number) => Record<string, any>} optionsOf returns the options of the run of a cell
   */
  constructor(about, x, y, optionsOf) {
    this.about = about;
    this.x = x;
    this.y = y;
    this.optionsOf = optionsOf;
    this.variables = about.variables;
    this.width = x.values.length;
    this.height = y.values.length;
    const count = this.width * this.height;
    this.values = this.variables.map(() => new Float64Array(count).fill(NaN));
    this.status = new Uint8Array(count).fill(NOT_YET);
    // How coarse the point is that a cell has its colour from; 1 is its own.
    this.stride = new Uint8Array(count).fill(NOT_YET);
    /** How many cells have their own point. */
    this.done = 0;
  }

  /** Return whether a cell has its own point. @param {number} at */
  isKnown(at) {
    return this.stride[at] === 1;
  }

  /**
   * Take in cells: a coarse point also colours the cells about it, the last ones of a row and a column
   * all to the border, until they have their own.
   * @param {Cells} cells
   */
  put({ cell, stride, status, values: rows }) {
    for (let i = 0; i < cell.length; i += 1) {
      const s = stride[i];
      const middleRow = Math.floor(cell[i] / this.width);
      const middleColumn = cell[i] % this.width;
      const half = s >> 1;
      const end = (/** @type {number} */ middle, /** @type {number} */ size) =>
        (middle + s < size ? middle + Math.max(half, 1) : size);
      const top = end(middleRow, this.height);
      const right = end(middleColumn, this.width);
      for (let r = Math.max(0, middleRow - half); r < top; r += 1)
        for (let c = Math.max(0, middleColumn - half); c < right; c += 1) {
          const at = r * this.width + c;
          const own = at === cell[i];
          if (own && !this.isKnown(at)) this.done += 1;
          if (!own && this.stride[at] <= s) continue;
          this.stride[at] = own ? 1 : s;
          this.status[at] = status[i];
          for (let k = 0; k < rows.length; k += 1) this.values[k][at] = rows[k][i];
        }
    }
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
   * Return why a cell has no value, null if it has one.
   * @param {number} at
   * @param {number} k place of the variable
   */
  lack(at, k) {
    const status = this.status[at];
    if (status === NOT_YET) return "notYet";
    if (status >= FIRST_BAD) return "mapNone";
    return Number.isNaN(this.values[k][at]) ? "noValue" : null;
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
    const values = this.values[k].filter((value) => Number.isFinite(value) && !(positive && value <= 0));
    if (!values.length) return positive ? [0.1, 1] : [0, 1];
    return axisLimits(...range(values), SINGLE); // finer ones cannot be read off
  }
}
