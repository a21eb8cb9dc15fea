/** A computed map as tables: a scenario of its sweep, and a file of comma-separated values. */

import { column as columnOf, csv, tablesOf } from "../model/run_files.js";
import { InputError } from "../model/rules.js";
import { t } from "../strings.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./question.js").MapQuestion} MapQuestion */

const FORMAT = 1;

/**
 * Return a map as the options of its runs and its sweep, which the installed program computes.
 * @param {MapQuestion} question
 */
export function mapTables({ registry, options, x, y, plan, watched, duration, transient, periods }) {
  const varied = [x, y].map(({ name }) => registry.axes[name].sets);
  const gone = ["times", "samples", "frame",
    ...(varied.includes("initial_angle") ? ["initial_angle", "initial_offset"] : [])];
  const kept = Object.entries(options).filter(([name, value]) => value !== null && !gone.includes(name));
  return {
    options: { ...Object.fromEntries(kept), duration, tolerance: registry.sweep_tolerance },
    sweep: { axes: Object.fromEntries([plan.y, plan.x].map(({ name, values }) => [name, Array.from(values)])),
      observables: watched.map(({ name, parameters }) => ({ kind: name, ...parameters })),
      transient, transient_periods: periods },
  };
}

/**
 * Return the points of the map on show: the values of its axes, the cells in which they lie, and how
 * many are not computed. A coarse map is a whole one of fewer points, except with kicks: those of a
 * cell follow from its number among all.
 * @param {MapQuestion} question
 * @param {Grid} grid
 */
export function pointsOnShow({ request, plan }, grid) {
  const { width, height, done } = grid;
  const isWhole = done === width * height || "noise_strength" in plan.parameters;
  const stride = isWhole ? 1 : request.stride ?? 1;
  const [x, y] = [plan.x, plan.y].map(({ name, values }) =>
    ({ name, values: Array.from(values).filter((_, k) => k % stride === 0) }));
  const cells = y.values.flatMap((_, row) => x.values.map((__, column) => stride * (row * width + column)));
  return { x, y, stride, cells, missing: cells.filter((cell) => !grid.isKnown(cell)).length };
}

/**
 * Return the points of the map on show as a table with a row for each, which `latolato.load` reads.
 * @param {MapQuestion} question
 * @param {Grid} grid
 * @returns {string}
 */
export function csvOf(question, grid) {
  const { registry, layout, watched } = question;
  const several = watched.find(({ name }) => layout.observables[name].dimension === "exponent");
  if (several)
    throw new InputError(t("refuseTable", { name: Object.keys(layout.observables[several.name].widths)[0] }));
  const { x, y, stride, cells, missing } = pointsOnShow(question, grid);
  const { width, height } = grid;
  const column = (/** @type {string} */ name, /** @type {import("./grid.js").Axis | import("./grid.js").Variable} */ shown,
    /** @type {(cell: number) => number} */ at) =>
    columnOf(name, { ...shown, shownUnit: shown.units[0]?.name ?? shown.unit }, (row) => at(cells[row]));
  const columns = [
    column(grid.y.name, grid.y, (cell) => grid.y.values[Math.floor(cell / width)]),
    column(grid.x.name, grid.x, (cell) => grid.x.values[cell % width]),
    ...grid.variables.map((variable, k) => column(variable.ball ? `${variable.name}_${variable.ball}` : variable.name,
      variable, (cell) => (grid.isKnown(cell) ? grid.values[k][cell] : NaN))),
    columnOf("status", { unit: "1", shownUnit: "1", label: "status of the point" },
      (row) => (grid.isKnown(cells[row]) ? layout.statuses[grid.status[cells[row]]] : "missing")),
  ];
  const about = { title: `latolato sweep of ${question.options.system}`, latolato_version: registry.version,
    rounding: "page", ...constantsOf(question),
    ...(stride > 1 ? { subset: `every ${stride}th value along both axes of a map of ${width} x ${height} points` } : {}),
    ...(missing ? { unfinished: `${missing} of ${cells.length} points are not computed: status is 'missing' there` } : {}),
    plan: JSON.stringify(described({ ...question, plan: { ...question.plan, x, y } })), format: FORMAT };
  return csv(registry, about, columns, cells.length);
}

/**
 * Return the parameters that do not vary.
 * @param {MapQuestion} question
 */
function constantsOf({ registry, options, x, y, duration, transient, periods }) {
  const varied = [x, y].flatMap(({ name }) => [name, registry.axes[name].sets]);
  const all = { ...options, duration, transient, transient_periods: periods,
    tolerance: registry.sweep_tolerance };
  return Object.fromEntries(Object.entries(all).filter(([name, value]) =>
    value !== null && !varied.includes(name) && !["times", "samples", "frame"].includes(name))
    .map(([name, value]) => [name, Array.isArray(value) ? JSON.stringify(value) : value]));
}

/**
 * Return the plan of a map as `latolato.sweeps.plan` describes it.
 * @param {MapQuestion} question
 */
function described({ registry, options, plan, watched, duration, transient, periods }) {
  const { system, drive, noise } = tablesOf(registry, options);
  const { parameters, x, y } = plan;
  const start = Object.fromEntries(Object.entries(parameters).filter(([name]) => name.startsWith("initial_")));
  return {
    format: FORMAT, system, drive, start,
    axes: [y, x].map(({ name, values }) => ({ name, parameters: [name], values: [Array.from(values)] })),
    observables: watched.map(({ name, parameters: own }) => ({ kind: name, ...own })),
    contact: { kind: options.contact ?? "exact",
      ...(parameters.step ? { clamp_step: parameters.step } : {}) },
    noise: noise ?? null, duration, transient, transient_periods: periods,
    tolerance: parameters.tolerance, rest_speed: parameters.rest_speed, contact_limit: plan.contact_limit,
    continuation: "", direction: "up", chunk_size: Math.max(x.values.length * y.values.length, 1),
  };
}
