/** Ways over a map: enlarged, and moved by whole cells; the browser's Back returns. */

import { notify } from "../page/dom.js";
import { t } from "../strings.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Axis} Axis */
/** @typedef {import("./view.js").MapView} MapView */
/** @typedef {import("./chart.js").ChartBox} ChartBox */

/**
 * Go to another part of the map of a view, which the address keeps; a stored map has no other.
 * @param {MapView} view
 * @param {(grid: Grid) => ChartBox} box
 */
export function zoom({ grid, controls }, box) {
  if (!grid) return;
  if (grid.about.stored) {
    notify(t("mapStoredZoom"));
    return;
  }
  const [xlow, xhigh, ylow, yhigh] = box(grid);
  controls.keep({ x: grid.x.name, y: grid.y.name, xlow, xhigh, ylow, yhigh,
    xlog: grid.x.log ? 1 : null, ylog: grid.y.log ? 1 : null });
}

/**
 * @param {MapView} view
 * @param {number} by factor of the lengths of both axes
 */
export function scale(view, by) {
  zoom(view, (grid) => scaledBox(grid, by, view.chart.cross));
}

/**
 * Move to the cells beside.
 * @param {MapView} view
 * @param {number} columns
 * @param {number} rows
 */
export function pan(view, columns, rows) {
  const { stride = 1 } = view.request;
  // The points of a coarse map are those of every so many cells.
  const [across, up] = [columns, rows].map((cells) => stride * Math.round(cells / stride));
  if (across || up) zoom(view, (grid) => movedBy(grid, across, up));
}

/**
 * Return an axis as it is measured: functions to that measure and from it, the logarithm on a logarithmic one,
 * and the limits of values in it.
 * @param {Axis} axis
 */
function measure({ log, allowed: [least, most] = [null, null] }) {
  const same = (/** @type {number} */ value) => value;
  const { to, from } = log ? { to: Math.log, from: Math.exp } : { to: same, from: same };
  // Amounts have no least logarithm.
  return { to, from, least: to(Math.max(least ?? -Infinity, log ? 0 : -Infinity)), most: to(most ?? Infinity) };
}

/**
 * Return the box whose sides are so many times as long, inside of what is allowed.
 * @param {Grid} grid
 * @param {number} by
 * @param {[number, number] | null} about its middle where it gets smaller
 * @returns {ChartBox}
 */
export function scaledBox(grid, by, about) {
  return boxOf(grid, (axis, k) => {
    const { to, least, most } = measure(axis);
    const [low, high] = [axis.edges[0], axis.edges[axis.edges.length - 1]].map(to);
    const place = by < 1 && about ? to(about[k]) : 0.5 * (low + high);
    const half = 0.5 * by * (high - low);
    return [Math.max(least, place - half), Math.min(most, place + half)];
  });
}

/**
 * Return the map so many cells to the right and up; it stays inside of what is allowed.
 * @param {Grid} grid
 * @param {number} columns
 * @param {number} rows
 */
export function movedBy(grid, columns, rows) {
  return boxOf(grid, (axis, k) => {
    const { to, least, most } = measure(axis);
    const [first, last] = [axis.values[0], axis.values[axis.values.length - 1]].map(to);
    const step = (last - first) / (axis.values.length - 1);
    const down = Math.floor((first - least) / step + 1e-9);
    const up = Math.floor((most - last) / step + 1e-9);
    const cells = Math.min(Math.max([columns, rows][k], -down), up);
    return [first + cells * step, last + cells * step];
  });
}

/**
 * Return a box from both ends of each axis in its measure.
 * @param {Grid} grid
 * @param {(axis: Axis, k: number) => number[]} ends
 * @returns {ChartBox}
 */
function boxOf({ x, y }, ends) {
  const [[a, b], [c, d]] = [x, y].map((axis, k) => ends(axis, k).map(measure(axis).from));
  return [a, b, c, d];
}
