/** From what a page asks of a map to the map itself, checked as `latolato.sweep` checks it. */

import { problemOf } from "../kernels/begin.js";
import { loadKernels, moduleFor } from "../kernels/load.js";
import { resolvedOf } from "../model/run_block.js";
import { checkPerturbations, checkStrings, contactOf, noiseOf, numbersFor, offsetOf } from "../model/case.js";
import { checkAcross, checkHanging, driveOf, planarOption, systemOf } from "../model/laws.js";
import { optionsOf, partsOf, withoutAlternatives, withoutRatios } from "../model/options.js";
import { brokenRule, checkedNumber, general, InputError, rangeOf, refusal, unknown } from "../model/rules.js";
import { t } from "../strings.js";
import { gentleDrive, isOfStrings, axisSpans, watchedOf } from "./choices.js";

/** @typedef {import("../kernels/memory.js").Layout} Layout */
/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("./choices.js").Span} Span */
/** @typedef {import("./grid.js").Axis & Span} SpannedAxis */

/**
 * What a page asks for; null leaves the choice to what the scenario says. With a stride, only every
 * second, fourth, ... row and column is computed.
 * @typedef {{scenario: string | null, options: Record<string, any>, x: import("./choices.js").Asked,
 *   y: import("./choices.js").Asked, observable: string | null, width: number, height: number,
 *   stride?: number, duration: number | null, transient: number | null}} MapRequest
 *
 * A map that can be computed: every option of its runs in SI units, its axes and their values, what
 * is gathered and which variable of that is shown.
 * @typedef {{registry: Registry, layout: Layout, request: MapRequest, options: Record<string, any>,
 *   title: string, x: SpannedAxis, y: SpannedAxis, watched: import("./choices.js").Watched[],
 *   shown: string, choices: import("./choices.js").Choice[], duration: number, transient: number,
 *   periods: number, plan: import("./plan.js").Plan}} MapQuestion
 */

const MOST_CELLS = 250_000;
const MOST_STREAMS = 2 ** 53;
const USUAL_DURATION = 60; // s
const SIDES = ["_right", "_left"];
const START = ["initial_angle", "initial_angular_velocity", "initial_distance"];

/**
 * Return the map that a page asks for.
 * @param {Registry} registry
 * @param {Layout} layout
 * @param {MapRequest} request
 * @returns {Promise<MapQuestion>}
 */
export async function questionOf(registry, layout, request) {
  const { scenario, x: askedX, y: askedY, width, height } = request;
  const count = width * height;
  if (count > MOST_CELLS) throw new InputError(t("refuseCells", { most: MOST_CELLS, width, height }));
  const preset = registry.scenarios[scenario ?? ""];
  const sweep = preset?.sweep ?? null;
  const input = optionsOf(registry, request);
  checkLaws(registry, layout, input, request.observable);
  const kernels = await loadKernels(moduleFor(registry.systems[input.system].angles, planarOption(registry, input) !== null));
  const system = systemOf(registry, kernels, input.system, partsOf(registry, input).system);
  for (const name of [input.initial_distance === undefined ? "" : "initial_distance", askedX?.name, askedY?.name])
    if (name && isOfStrings(name)) checkStrings(system.suspension, name);
  const gentle = gentleDrive({ options: { ...system.balls[0], ...input, gravity: system.gravity }, sweep });
  const { drive: kind = "fixed_pivot" } = input;
  // A drive of which only the phase is given is varied by the axes as well.
  const usual = kind === gentle.drive ? withoutAlternatives(registry, gentle, Object.keys(input)) : {};
  const named = kind === "fixed_pivot" ? { ...input, ...gentle } : { ...usual, ...input };
  const parts = partsOf(registry, named);
  withoutRatios(registry, named.drive, parts.drive, system.naturalFrequency);
  const drive = driveOf(registry, named.drive, parts.drive);
  const law = contactOf(registry, system, parts.run);
  const noise = noiseOf(registry, parts.noise);
  const options = resolvedOf(/** @type {any} */ ({ registry, options: named, system, drive }));
  const { duration, transient, periods } = timesOf(registry, layout, request, options, sweep);
  const origin = { options, sweep };
  const { watched, shown, choices } = watchedOf(registry, layout, origin, request.observable);
  const [x, y] = axisSpans(registry, origin, [askedX, askedY])
    .map((span, k) => axisOf(registry, span, k ? height : width));
  checkVaried(registry, system, drive, [x, y]);
  const friction = [x, y].filter(({ name }) => name.endsWith("coulomb_damping")).map(({ high }) => high);
  for (const { name } of watched)
    if ("tangent" in layout.observables[name].callbacks)
      checkPerturbations(system.suspension,
        Math.max(...friction, ...system.balls.map((ball) => ball.coulomb_damping)), shown);
  checkWatched(registry, layout, watched, drive.kind, law.contact);
  if (noise && (noise.noise_stream ?? 0) + count > MOST_STREAMS)
    throw brokenRule("streams", {}, { count, first: Number(noise.noise_stream) });
  const number = (/** @type {string} */ name) =>
    checkedNumber(registry.options[name], name, options[name] ?? registry.options[name].default);
  const own = registry.systems[system.kind].options.filter((name) => typeof options[name] === "number");
  // An axis replaces what sets the same thing.
  const varied = [x, y].map(({ name }) => registry.axes[name].sets);
  const isFixed = (/** @type {[string, any]} */ [name]) => !varied.includes(registry.axes[name]?.sets);
  const inPlane = planarOption(registry, { ...system, drive: drive.kind, ...drive.parameters }) !== null
    || [x, y].some(({ name }) => name === registry.drives[drive.kind].across);
  const plan = {
    angles: /** @type {1 | 2} */ (system.angles), in_plane: inPlane, drive: drive.kind,
    parameters: { ...Object.fromEntries(Object.entries({
      ...Object.fromEntries(own.map((name) => [name, options[name]])), ...drive.parameters,
      ...startValues(registry, system, options, [x.name, y.name]) }).filter(isFixed)), ...noise, restitution: system.restitution,
      string_restitution: system.string_restitution, is_string: Number(system.suspension === "string"),
      in_lab: Number(system.drag_frame === "lab"),
      tolerance: registry.sweep_tolerance, rest_speed: number("rest_speed"), step: law.clampStep,
      is_linear: Number(system.linear), collides: Number(system.contacts && law.contact !== "none") },
    x: { name: x.name, values: x.values }, y: { name: y.name, values: y.values },
    observables: watched.map(({ name, parameters }) => ({ name, parameters: Object.fromEntries(
      Object.entries(parameters).map(([key, value]) => [key, Number(value)])) })),
    duration, transient, transient_periods: periods,
    contact: /** @type {"exact" | "clamp"} */ (law.clampStep ? "clamp" : "exact"),
    contact_limit: number("contact_limit"),
  };
  for (const { name, values } of [y, x])
    if (registry.options[name]?.whole)
      for (const value of values) checkedNumber(registry.options[name], name, value);
  return { registry, layout, request, options, title: preset?.title ?? "", x, y, watched, shown, choices,
    duration, transient, periods, plan };
}

/**
 * Throw unless pages have the laws of a map and what it shows.
 * @param {Registry} registry
 * @param {Layout} layout
 * @param {Record<string, any>} options
 * @param {string | null} observable
 */
function checkLaws(registry, layout, options, observable) {
  const { contact = "exact", drive = "fixed_pivot" } = options;
  for (const [part, laws, kind] of /** @type {const} */ ([["system", registry.systems, options.system],
    ["drive", registry.drives, drive], ["contact law", registry.contact_laws, contact]])) {
    if (!Object.hasOwn(laws, kind)) throw unknown(part, String(kind), Object.keys(laws));
    if (!laws[kind].compiled) throw beyond(part.split(" ")[0], kind);
  }
  const owners = Object.entries(registry.observables)
    .filter(([, { variables }]) => observable !== null && observable in variables);
  if (owners.length && !owners.some(([name]) => name in layout.observables))
    throw beyond("observable", owners[0][0]);
}

/** @type {(kind: string, name: string) => InputError} what is wrong with a map that the installed program computes */
const beyond = (kind, name) => new InputError(t("beyondMap", { what: t(`beyond_${kind}`, { name }) }));

/**
 * Throw if the system does not describe some values along the axes.
 * @param {Registry} registry
 * @param {import("../model/laws.js").System} system
 * @param {import("../model/laws.js").Drive} drive
 * @param {Span[]} axes
 */
function checkVaried(registry, system, drive, axes) {
  const largest = (/** @type {string} */ name) => axes.find((axis) => axis.name.endsWith(name))?.high;
  const { across } = registry.drives[drive.kind];
  const sideways = across ? { [across]: largest(across) ?? drive.parameters[across] } : {};
  checkAcross(registry, system, { ...drive, parameters: { ...drive.parameters, ...sideways } });
  const drag = largest("quadratic_damping");
  if (drag) checkHanging({ ...system, balls: [{ ...system.balls[0], quadratic_damping: drag }] });
}

/**
 * Return how long runs last and how much of their beginning is left out [s].
 * @param {Registry} registry
 * @param {Layout} layout
 * @param {MapRequest} request
 * @param {Record<string, any>} options
 * @param {any} sweep
 */
function timesOf(registry, layout, request, options, sweep) {
  const { duration: own, times } = options;
  const duration = request.duration ?? own ?? times?.at(-1) ?? USUAL_DURATION;
  const transient = request.transient ?? sweep?.transient ?? 0;
  if (!(duration > 0))
    throw new InputError(t("refuseDuration", { value: general(duration) }), { fields: ["duration"] });
  if (!(transient >= 0))
    throw new InputError(t("refuseTransient", { title: t("mapTransient"), value: general(transient) }),
      { fields: ["transient"] });
  if (transient >= duration)
    throw refusal(problemOf(layout, "transient", [transient, duration]), ["transient", "duration"]);
  checkedNumber(registry.options.duration, "duration", duration);
  return { duration, transient,
    periods: request.transient === null ? sweep?.transient_periods ?? 0 : 0 };
}

/**
 * Return how runs begin, by the names of axes.
 * @param {Registry} registry
 * @param {import("../model/laws.js").System} system
 * @param {Record<string, any>} options
 * @param {string[]} varied
 */
function startValues(registry, system, options, varied) {
  const sides = system.angles === 1 ? [""] : SIDES;
  /** @type {Record<string, number>} */
  const start = {};
  const offset = offsetOf(registry, system, options);
  if (offset !== null) start.initial_offset = offset;
  for (const name of START) {
    const value = options[name] ?? (name === "initial_angular_velocity" ? 0 : null);
    if (value === null) continue;
    numbersFor(registry, name, value, system.angles).forEach((each, i) => { start[name + sides[i]] = each; });
  }
  const missing = sides.map((side) => START[0] + side)
    .find((name) => !(name in start) && !varied.includes(name));
  if (missing && !("initial_offset" in start) && !varied.includes("initial_offset"))
    throw brokenRule("axis_needed", {}, { name: missing });
  return start;
}

/**
 * Throw unless observables go together with the laws of a run.
 * @param {Registry} registry
 * @param {Layout} layout
 * @param {import("./choices.js").Watched[]} watched
 * @param {string} drive
 * @param {string} contact
 */
function checkWatched(registry, layout, watched, drive, contact) {
  for (const { name } of watched) {
    const { marks, callbacks, widths } = layout.observables[name];
    if (marks && !registry.drives[drive].periodic)
      throw brokenRule("single_period", {}, { name: drive });
    if ("jacobian_report" in callbacks && contact === "clamp")
      throw brokenRule("exact_contact", {}, { name: Object.keys(widths)[0] });
  }
}

/**
 * Return an axis with its cells.
 * @param {Registry} registry
 * @param {Span} span
 * @param {number} count of the cells
 * @returns {SpannedAxis}
 */
function axisOf({ axes }, span, count) {
  const { label, symbol, unit, units, limits } = axes[span.name];
  const values = cellValues(span, count);
  return { ...span, label, symbol, unit, units, allowed: rangeOf(limits).map((limit) => limit?.end ?? null), values, edges: edgesOf(values, span.log) };
}

/**
 * Return the values at the middles of the cells, both ends included.
 * @param {Span} span
 * @param {number} count
 */
function cellValues({ low, high, log }, count) {
  const [first, last] = log ? [Math.log10(low), Math.log10(high)] : [low, high];
  const step = (last - first) / (count - 1);
  const values = Float64Array.from({ length: count }, (_, i) => i * step + first);
  const own = log ? values.map((value) => 10 ** value) : values;
  own[0] = low;
  own[count - 1] = high;
  return own;
}

/**
 * Return the borders of cells, midway between values; of amounts, never below zero.
 * @param {Float64Array} values
 * @param {boolean} log
 */
function edgesOf(values, log) {
  const along = log ? values.map(Math.log) : values;
  const last = along.length - 1;
  const edges = Float64Array.from({ length: last + 2 }, (_, i) => {
    if (i === 0) return along[0] - 0.5 * (along[1] - along[0]);
    if (i > last) return along[last] + 0.5 * (along[last] - along[last - 1]);
    return 0.5 * (along[i - 1] + along[i]);
  });
  if (log) return edges.map(Math.exp);
  return values[0] >= 0 ? edges.map((edge) => Math.max(edge, 0)) : edges;
}
