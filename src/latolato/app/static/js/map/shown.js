/** The map on show, in the words in which the server is asked for files of it. */

import { lookOf } from "./look.js";
import { tablesOf } from "./table.js";

/** @typedef {import("./view.js").MapView} MapView */

/**
 * Return which map is on show: a stored one, or one of the page by its runs and its sweep.
 * @param {MapView} view
 */
export function shownMapOf({ grid, request, question }) {
  const axes = { xlog: grid?.xAxis.log ?? null, ylog: grid?.yAxis.log ?? null };
  return question ? { ...tablesOf(question), ...axes }
    : { stored: request.stored ?? null, select: request.select ?? {}, ...axes };
}

/**
 * Return what a file of the map on show is asked by.
 * @param {MapView} view
 * @param {import("./grid.js").Grid} grid
 */
export function fileRequestOf(view, grid) {
  const { chart, over, page } = view;
  const { variable, scale, log, limits } = lookOf(grid, page.store.state.extra);
  const { name, ball } = grid.variables[variable];
  const contours = over.contourBody();
  const levels = [...new Set(chart.contours.map(({ level }) => level))];
  return { ...shownMapOf(view), observable: name, ball, scale, log, limits,
    contours: contours && levels.length
      ? { observable: contours.observable, ball: contours.ball, levels } : null,
    overlays: over.shown().map((line) => line.name), trials: over.trials };
}
