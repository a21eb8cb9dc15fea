/** Ways over a map: enlarged, moved by whole cells, and back. */

import { notify } from "../page/dom.js";
import { t } from "../strings.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Axis} Axis */
/** @typedef {import("./chart.js").ChartBox} ChartBox */

/** Ways over the map of a view, kept in the address. */
export class Travel {
  /** @param {import("./view.js").MapView} view */
  constructor(view) {
    this.view = view;
    /** @type {Record<string, string>[]} keys of the address of maps that were seen */
    this.seen = [];
  }

  /**
   * Go to another part of the map; a stored one has no other.
   * @param {(grid: Grid) => ChartBox} box
   */
  go(box) {
    const { grid, controls } = this.view;
    if (!grid) return;
    if (grid.about.stored) {
      notify(t("mapStoredZoom"));
      return;
    }
    const [xlow, xhigh, ylow, yhigh] = box(grid);
    controls.keep({ x: grid.xAxis.name, y: grid.yAxis.name, xlow, xhigh, ylow, yhigh,
      xlog: grid.xAxis.log ? 1 : null, ylog: grid.yAxis.log ? 1 : null });
  }

  /** @param {ChartBox} box */
  zoom(box) {
    const { extra } = this.view.page.store.state;
    if (!this.view.grid?.about.stored) this.seen.push(placeOf(extra));
    this.go(() => box);
  }

  /** @param {number} by factor of the lengths of both axes */
  scale(by) {
    const { grid, chart } = this.view;
    if (grid) this.zoom(scaledBox(grid, by, chart.cross));
  }

  /**
   * Move to the cells beside.
   * @param {number} columns
   * @param {number} rows
   */
  pan(columns, rows) {
    const { stride = 1 } = this.view.request;
    // The points of a coarse map are those of every so many cells.
    const [across, up] = [columns, rows].map((cells) => stride * Math.round(cells / stride));
    if (across || up) this.go((grid) => movedBy(grid, across, up));
  }

  /** Zoom out to the map before. */
  back() {
    const last = this.seen.pop();
    const { store } = this.view.page;
    if (last) store.set({ extra: { ...withoutPlace(store.state.extra), ...last } }, "extra");
  }
}

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
  return /^map\.[xy](low|high|log)?$/.test(name);
}

/**
 * Return how far a value lies along an axis, and back: its logarithm on a logarithmic one.
 * @param {Axis} axis
 */
function measure(axis) {
  return axis.log ? { to: Math.log, from: Math.exp }
    : { to: (/** @type {number} */ v) => v, from: (/** @type {number} */ v) => v };
}

/**
 * The limits of values along an axis, in its measure.
 * @param {Axis} axis
 */
function allowedOf(axis) {
  const [least, most] = axis.allowed ?? [];
  const { to } = measure(axis);
  return [to(least ?? -Infinity), to(most ?? Infinity)].map((v, k) =>
    Number.isNaN(v) ? [-Infinity, Infinity][k] : v);
}

/**
 * Return the box whose sides are so many times as long, inside of what is allowed.
 * @param {Grid} grid
 * @param {number} by
 * @param {[number, number] | null} about its middle where it gets smaller
 * @returns {ChartBox}
 */
export function scaledBox(grid, by, about) {
  const [x, y] = /** @type {const} */ ([[grid.xEdges, grid.xAxis], [grid.yEdges, grid.yAxis]])
    .map(([edges, axis], k) => {
      const { to, from } = measure(axis);
      const [low, high] = [to(edges[0]), to(edges[edges.length - 1])];
      const place = by < 1 && about ? to(about[k]) : 0.5 * (low + high);
      const half = 0.5 * by * (high - low);
      const [least, most] = allowedOf(axis);
      return [from(Math.max(least, place - half)), from(Math.min(most, place + half))];
    });
  return [x[0], x[1], y[0], y[1]];
}

/**
 * Return the map so many cells to the right and up; it stays inside of what is allowed.
 * @param {Grid} grid
 * @param {number} columns
 * @param {number} rows
 * @returns {ChartBox}
 */
export function movedBy(grid, columns, rows) {
  const along = (/** @type {Float64Array} */ values, /** @type {Axis} */ axis,
    /** @type {number} */ by) => {
    const { to, from } = measure(axis);
    const [first, last] = [to(values[0]), to(values[values.length - 1])];
    const step = (last - first) / (values.length - 1);
    const [least, most] = allowedOf(axis);
    const down = Math.floor((first - least) / step + 1e-9);
    const up = Math.floor((most - last) / step + 1e-9);
    const cells = Math.min(Math.max(by, -down), up);
    return [from(first + cells * step), from(last + cells * step)];
  };
  const [x, y] = [along(grid.x, grid.xAxis, columns), along(grid.y, grid.yAxis, rows)];
  return [x[0], x[1], y[0], y[1]];
}
