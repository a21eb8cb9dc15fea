/** Points of maps that have been computed: what goes on, moves or zooms out begins with these. */

import { NOT_YET } from "./grid.js";

/**
 * @typedef {import("./plan.js").Plan} Plan
 * @typedef {{plan: Plan, key: string, status: Uint8Array, values: Float64Array[]}} Known
 */

// Maps that were looked at last stay in memory.
const MOST_MAPS = 8;
// Values of an axis this close, in spacings, are the same: those of a moved map are rounded.
const SAME = 1e-6;

export class Memory {
  constructor() {
    /** @type {Known[]} the last one first */
    this.maps = [];
  }

  /**
   * The known points of a map, including those that it shares with other maps.
   * @param {Plan} plan
   * @param {number} rows how many numbers a point has
   */
  begin(plan, rows) {
    const { x, y, ...others } = plan;
    const key = JSON.stringify([others, x.name, y.name]);
    const count = x.values.length * y.values.length;
    const known = { plan, key, status: new Uint8Array(count).fill(NOT_YET),
      values: Array.from({ length: rows }, () => new Float64Array(count)) };
    // Kicks are those of a cell's number, which another map counts otherwise.
    const isSame = (/** @type {Known} */ other) => !("noise_strength" in plan.parameters)
      || (String(other.plan.x.values) === String(x.values)
        && String(other.plan.y.values) === String(y.values));
    for (const other of this.maps) if (other.key === key && isSame(other)) takeOver(known, other);
    this.maps = [known, ...this.maps].slice(0, MOST_MAPS);
    return known;
  }
}

/**
 * Return the cells of a map that are computed.
 * @param {Known} known
 */
export function cellsOf({ status }) {
  return Int32Array.from([...status.keys()].filter((cell) => status[cell] !== NOT_YET));
}

/**
 * Write points of a map.
 * @param {Known} known
 * @param {Int32Array} cells
 * @param {{status: ArrayLike<number>, values: ArrayLike<number>[]}} points
 */
export function put(known, cells, { status, values }) {
  cells.forEach((cell, k) => {
    known.status[cell] = status[k];
    known.values.forEach((row, i) => {
      row[cell] = values[i][k];
    });
  });
}

/**
 * Return the values of some cells.
 * @param {Known} known
 * @param {Int32Array} cells
 */
export function pointsAt({ status, values }, cells) {
  return { status: Uint8Array.from(cells, (cell) => status[cell]),
    values: values.map((row) => Float64Array.from(cells, (cell) => row[cell])) };
}

/**
 * Put the points of another map where the same ones of this map are not known yet.
 * @param {Known} known
 * @param {Known} other
 */
function takeOver(known, other) {
  const columns = shared(known.plan.x.values, other.plan.x.values);
  const rows = shared(known.plan.y.values, other.plan.y.values);
  const [width, there] = [known.plan.x.values.length, other.plan.x.values.length];
  const pairs = rows.flatMap(([row, from]) => columns.map(([column, at]) =>
    [row * width + column, from * there + at]));
  const fresh = pairs.filter(([cell, from]) =>
    known.status[cell] === NOT_YET && other.status[from] !== NOT_YET);
  put(known, Int32Array.from(fresh, ([cell]) => cell),
    pointsAt(other, Int32Array.from(fresh, ([, from]) => from)));
}

/**
 * Return the places of equal values of two axes, in pairs.
 * @param {ArrayLike<number>} here
 * @param {ArrayLike<number>} there
 */
function shared(here, there) {
  const size = here.length;
  const spacing = size > 1 ? Math.abs(here[1] - here[0]) : Math.abs(here[0]) || 1;
  /** @type {[number, number][]} */
  const pairs = [];
  for (let i = 0, k = 0; i < size; i += 1) {
    while (k < there.length - 1 && there[k] < here[i] - SAME * spacing) k += 1;
    if (Math.abs(there[k] - here[i]) <= SAME * spacing) pairs.push([i, k]);
  }
  return pairs;
}
