/** What a computed map is of, as its picture, its readout and its files say it, and its runs. */

import { Grid } from "./grid.js";
import { sweepCommand, sweepLines } from "./map_code.js";
import { variablesOf } from "./plan.js";
import { t } from "../strings.js";

/** @typedef {import("./question.js").MapQuestion} MapQuestion */
/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {Record<string, any>} Options */

const SIDES = ["right", "left"];

/**
 * Return a map without any points.
 * @param {MapQuestion} question
 */
export function gridOf(question) {
  const { registry, layout, options, plan, shown, title, x, y } = question;
  const { contacts, options: own } = registry.systems[options.system];
  const parameters = Object.fromEntries(own.filter((name) => name in options && name !== x.name && name !== y.name)
    .map((name) => [name, options[name]]));
  return new Grid({ observable: shown, title, parameters, laws: { ...options, contact: contacts ? options.contact ?? "exact" : "none" },
    statuses: layout.statuses.map((name) => name.replaceAll("_", " ")),
    variables: variablesOf(layout, plan).map((each) => variableOf(question, each)),
    has_contact: contacts && options.contact !== "none",
    python: sweepLines(question), command: sweepCommand(question) }, x, y, (cell) => optionsOfCell(question, cell));
}

/**
 * Return how a variable is shown.
 * @param {MapQuestion} question
 * @param {import("./plan.js").PlanVariable} variable
 * @returns {import("./grid.js").Variable}
 */
function variableOf({ registry, layout, options, watched }, { name, ball }) {
  const owner = watched.find((each) => name in registry.observables[each.name].variables)?.name ?? "";
  const { label, ...rest } = registry.observables[owner].variables[name];
  const { angles, contacts } = registry.systems[options.system];
  const both = angles === 2 && layout.observables[owner].joint;
  const whose = contacts && rest.unit === "J" ? `, ${t(both ? "bothBalls" : "perBall")}` : "";
  return { name, ball: ball === null ? null : SIDES[ball], label: label + whose, ...rest };
}

/**
 * Return options with values of a map's axes put in, also of those that stand for others.
 * @param {Registry} registry
 * @param {Options} options in SI units
 * @param {Record<string, number>} values by the names of axes
 * @returns {Options}
 */
export function optionsAt(registry, options, values) {
  const result = { ...options };
  for (const [name, value] of Object.entries(values)) {
    const { sets } = registry.axes[name];
    if (sets === "initial_angle") {
      delete result.initial_angle;
      delete result.initial_offset;
    }
    const side = SIDES.findIndex((each) => name.endsWith(`_${each}`));
    const pair = side < 0 ? "" : name.slice(0, -SIDES[side].length - 1);
    if (registry.options[pair]?.for_each_ball) {
      const lengths = SIDES.map((each) => values[`${each}_length`] ?? result[`${each}_length`]);
      const [right, left = right] = [result[pair] ?? (pair === "initial_distance" ? lengths : 0)].flat();
      result[pair] = [right, left];
      result[pair][side] = value;
    } else if (sets === name || sets === "initial_angle") result[name] = value;
  }
  const length = result.length ?? result.right_length;
  const { frequency_ratio: ratio, amplitude_ratio: amplitude, drive_acceleration_ratio: acceleration } = values;
  if (ratio !== undefined) result.drive_frequency = ratio * Math.sqrt(result.gravity / length);
  if (amplitude !== undefined) result.drive_amplitude = amplitude * length;
  if (acceleration !== undefined)
    result.drive_amplitude = (acceleration * result.gravity) / result.drive_frequency ** 2;
  return result;
}

/**
 * Return the options of the run of a cell.
 * @param {MapQuestion} question
 * @param {number} cell
 */
export function optionsOfCell({ registry, options, x, y, duration }, cell) {
  const width = x.values.length;
  /** @type {Options} */
  const base = { ...options, duration, tolerance: registry.sweep_tolerance };
  for (const name of ["times", "samples"]) delete base[name];
  // The kicks of a cell are those of its own random stream, unless an axis says which.
  if (base.noise_strength !== undefined && ![x.name, y.name].some((name) => /^noise_(seed|stream)$/.test(name)))
    base.noise_stream = (base.noise_stream ?? 0) + cell;
  return optionsAt(registry, base, { [x.name]: x.values[cell % width],
    [y.name]: y.values[Math.floor(cell / width)] });
}
