/** How the values of a map become colours, as the address says. */

import { axisLimits } from "../shared/axis.js";
import { SCALES } from "./colours.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./chart.js").Look} Look */

/**
 * Return which variable is shown and how its values become colours.
 * @param {Grid} grid
 * @param {Record<string, string>} extra
 * @returns {Look}
 */
export function lookOf(grid, extra) {
  const name = extra["map.observable"] ?? grid.about.observable;
  const chosen = grid.variable(name, extra["map.ball"] ?? null);
  const variable = Math.max(0, chosen >= 0 ? chosen : grid.variable(name));
  const about = grid.variables[variable];
  const usual = about.log ? "1" : "0";
  const log = (extra["map.log"] ?? usual) === "1" && !about.classes.length;
  const [low, high] = grid.range(variable, log);
  const given = (/** @type {string} */ key, /** @type {number} */ usual) => {
    const value = Number(extra[key] ?? NaN);
    return Number.isFinite(value) && (!log || value > 0) ? value : usual;
  };
  const [from, to] = [given("map.low", low), given("map.high", high)];
  return { variable, scale: extra["map.scale"] ?? about.scale ?? SCALES[0], log,
    limits: from < to ? axisLimits(from, to) : [low, high] };
}
