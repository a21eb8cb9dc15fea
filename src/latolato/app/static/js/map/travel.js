/** Ways over a map: enlarged, moved by whole cells. */

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./chart.js").Box} Box */
/** @typedef {{grid: Grid, columns: number, rows: number}} Moved */

/**
 * Return the keys of the address that say which part of which map is on show.
 * @param {Record<string, string>} extra
 * @returns {Record<string, string>}
 */
export function placeOf(extra) {
  return Object.fromEntries(Object.entries(extra).filter(([name]) => isPlace(name)));
}

/**
 * Return the keys of the address without those.
 * @param {Record<string, string>} extra
 * @returns {Record<string, string>}
 */
export function withoutPlace(extra) {
  return Object.fromEntries(Object.entries(extra).filter(([name]) => !isPlace(name)));
}

/** @param {string} name */
function isPlace(name) {
  return /^map\.[xy](low|high)?$/.test(name);
}

/**
 * Return the box whose sides are so many times as long, inside of what is allowed.
 * @param {Grid} grid
 * @param {number} by
 * @param {[number, number] | null} about its middle where it gets smaller
 * @returns {Box}
 */
export function scaledBox(grid, by, about) {
  const [x, y] = /** @type {const} */ ([[grid.xEdges, grid.xAxis], [grid.yEdges, grid.yAxis]])
    .map(([edges, axis], k) => {
      const [low, high] = [edges[0], edges[edges.length - 1]];
      const middle = by < 1 ? about?.[k] ?? 0.5 * (low + high) : 0.5 * (low + high);
      const half = 0.5 * by * (high - low);
      const [least, most] = axis.allowed ?? [];
      const bottom = Math.max(least ?? -Infinity, middle - half);
      return [bottom, Math.min(most ?? Infinity, middle + half)];
    });
  return [x[0], x[1], y[0], y[1]];
}

/**
 * Return the map so many cells to the right and up, and what of it is known; it stays inside of
 * what is allowed.
 * @param {Grid} grid
 * @param {number} columns
 * @param {number} rows
 * @returns {{box: Box, moved: Moved, known: [number, number, number, number] | null}}
 */
export function movedBy(grid, columns, rows) {
  const along = (/** @type {Float64Array} */ values, /** @type {(number | null)[]} */ allowed,
    /** @type {number} */ by) => {
    const last = values[values.length - 1];
    const step = (last - values[0]) / (values.length - 1);
    const [least, most] = allowed;
    const down = Math.floor((values[0] - (least ?? -Infinity)) / step + 1e-9);
    const up = Math.floor(((most ?? Infinity) - last) / step + 1e-9);
    const cells = Math.min(Math.max(by, -down), up);
    return { cells, low: values[0] + cells * step, high: last + cells * step };
  };
  const x = along(grid.x, grid.xAxis.allowed ?? [], columns);
  const y = along(grid.y, grid.yAxis.allowed ?? [], rows);
  const first = Math.max(0, -x.cells);
  const last = Math.min(grid.width, grid.width - x.cells) - 1;
  const low = Math.max(0, -y.cells);
  const high = Math.min(grid.height, grid.height - y.cells) - 1;
  return {
    box: [x.low, x.high, y.low, y.high],
    moved: { grid, columns: x.cells, rows: y.cells },
    known: grid.complete && first <= last && low <= high ? [first, last, low, high] : null,
  };
}
