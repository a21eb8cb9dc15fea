/** Maps that open: those of the page, whose points are estimated first, and stored ones of the server. */

import { problemOf } from "../kernels/begin.js";
import { loadLayout } from "../kernels/load.js";
import { specify } from "../model/case.js";
import { InputError, refusal } from "../model/rules.js";
import { doJob } from "../page/jobs.js";
import { optionsAt, optionsOfCell } from "./about.js";
import { Grid } from "./grid.js";
import { questionOf } from "./question.js";

/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("./question.js").MapQuestion} MapQuestion */

// A point of more steps would let all wait for it.
const MOST_STEPS = 5e6;

/**
 * Return a map that the page can compute, and how many steps it takes.
 * @param {Registry} registry
 * @param {import("./pool.js").Pool} pool
 * @param {import("./question.js").MapRequest} request
 * @param {(question: MapQuestion) => void} [choose] called with what may be chosen, also if no point can run
 * @returns {Promise<{question: MapQuestion, estimate: import("./pool.js").Estimate}>}
 * @throws {InputError} if no point can run, or if one takes too long
 */
export async function ownMap(registry, pool, request, choose = () => {}) {
  const question = await questionOf(registry, await loadLayout(), request);
  choose(question);
  const estimate = await pool.estimate(question.plan);
  const { problem, longest } = estimate;
  // A law may have its own words.
  if (problem?.name === "out of range") await specify(registry, { options: optionsOfCell(question, 0) });
  if (problem) throw refusal(problem, problem.name === "transient" ? ["transient", "duration"] : undefined);
  if (longest > MOST_STEPS)
    throw refusal(problemOf(question.layout, "too many steps", [longest, question.duration / longest, MOST_STEPS]));
  return { question, estimate };
}

/**
 * Return a stored map, which the server opens, with all its cells.
 * @param {Registry} registry
 * @param {Record<string, any>} request
 * @param {AbortSignal} signal
 */
export async function storedMap(registry, request, signal) {
  const { about, arrays } = /** @type {any} */ (await doJob("ws/map/stored", request, { signal }));
  const { options, sets, streams, reason } = /** @type {import("./grid.js").Stored} */ (about.stored);
  const [x, y] = /** @type {const} */ (["x", "y"]).map((which) =>
    ({ ...about[which], values: arrays[which], edges: arrays[`${which}_edges`] }));
  const valuesAt = (/** @type {"x" | "y"} */ which, /** @type {number} */ at) =>
    Object.fromEntries(Object.entries(sets[which]).map(([name, values]) => [name, values[at]]));
  const width = x.values.length;
  const optionsOf = (/** @type {number} */ cell) => {
    if (!options) throw new InputError(reason);
    const [column, row] = [cell % width, Math.floor(cell / width)];
    const own = streams ? { noise_stream: streams.x[column] + streams.y[row] } : {};
    return optionsAt(registry, { ...options, ...own },
      { ...sets.all, ...valuesAt("x", column), ...valuesAt("y", row) });
  };
  const grid = new Grid(about, x, y, optionsOf);
  const count = arrays.status.length;
  grid.put({ cell: Int32Array.from({ length: count }, (_, i) => i), stride: new Uint8Array(count).fill(1),
    status: Uint8Array.from(arrays.status, (each) => each), values: [arrays.values] });
  return grid;
}
