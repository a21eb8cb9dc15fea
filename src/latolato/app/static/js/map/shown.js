/** The map on show, in the words in which the server is asked about it. */

import { lookOf } from "./look.js";
import { requestOf } from "./request.js";

/** @typedef {import("./view.js").MapView} MapView */

/**
 * Return the request for things about a map: the plan, and names of axes of a stored one.
 * @param {MapView} view
 * @returns {Record<string, any>}
 */
export function askedOf({ grid, page, choices }) {
  const request = requestOf(page.registry, page.store.state);
  if (request.stored)
    return { stored: request.stored, select: request.select,
      names: [grid?.xAxis.name, grid?.yAxis.name] };
  return { ...request, x: choices?.x ?? request.x, y: choices?.y ?? request.y };
}

/**
 * Return which map is on show, as the server knows it.
 * @param {MapView} view
 */
export function shownMapOf({ grid, page }) {
  const { stored, select } = requestOf(page.registry, page.store.state);
  return { key: grid?.about.key ?? null, stored: stored ?? null, select,
    xlog: grid?.xAxis.log ?? null, ylog: grid?.yAxis.log ?? null };
}

/**
 * Return what a file of the map on show is asked by, null before there is one.
 * @param {MapView} view
 */
export async function fileBodyOf(view) {
  const { grid, over } = view;
  if (!grid) return null;
  const { variable, scale, log, limits } = lookOf(grid, view.page.store.state.extra);
  const { name, ball } = grid.variables[variable];
  return { ...shownMapOf(view), observable: name, ball, scale, log, limits,
    contours: over.contourBody(), overlays: over.shown().map((line) => line.name),
    trials: over.trials };
}
