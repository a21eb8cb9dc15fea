/** Maps that were looked at: what goes on, moves or zooms out begins with their points. */

import { inOrder } from "./plan.js";

/** @typedef {import("./grid.js").Grid} Grid */

// Maps that were looked at last stay in memory.
const MOST_MAPS = 8;
// Values of an axis this close, in spacings, are the same: those of a moved map are rounded.
const SAME = 1e-6;

export class KnownMaps {
  constructor() {
    /** @type {{key: string, grid: Grid}[]} the last one first */
    this.maps = [];
  }

  /**
   * Put the points into a new map that it shares with those before, and remember it.
   * @param {Grid} grid
   * @param {import("./plan.js").Plan} plan
   */
  add(grid, { x, y, ...others }) {
    // Kicks are those of a cell's number, which a map with other axes counts otherwise.
    const key = JSON.stringify([others, "noise_strength" in others.parameters ? [x, y] : [x.name, y.name]]);
    for (const other of this.maps) if (other.key === key) takeOver(grid, other.grid);
    this.maps = [{ key, grid }, ...this.maps].slice(0, MOST_MAPS);
  }
}

/**
 * Put the points of another map where the same ones of this map are not known yet.
 * @param {Grid} grid
 * @param {Grid} other
 */
function takeOver(grid, other) {
  const [columns, rows] = [placesIn(other.x.values, grid.x.values), placesIn(other.y.values, grid.y.values)];
  const { cells, strides } = inOrder(grid.width, grid.height);
  const from = Array.from(cells, (cell) => {
    const [column, row] = [columns[cell % grid.width], rows[Math.floor(cell / grid.width)]];
    return column < 0 || row < 0 ? -1 : row * other.width + column;
  });
  const shared = [...cells.keys()].filter((k) => other.isKnown(from[k]) && !grid.isKnown(cells[k]));
  grid.put({ cell: Int32Array.from(shared, (k) => cells[k]), stride: Uint8Array.from(shared, (k) => strides[k]),
    status: shared.map((k) => other.status[from[k]]),
    values: other.values.map((row) => shared.map((k) => row[from[k]])) });
}

/**
 * Return where the values of an axis are among those of another, -1 for those that it lacks.
 * @param {ArrayLike<number>} there
 * @param {ArrayLike<number>} here
 */
function placesIn(there, here) {
  const close = SAME * (Math.abs(here[1] - here[0]) || Math.abs(here[0]) || 1);
  let k = 0;
  return Array.from(here, (value) => {
    while (k < there.length - 1 && there[k] < value - close) k += 1;
    return Math.abs(there[k] - value) <= close ? k : -1;
  });
}
