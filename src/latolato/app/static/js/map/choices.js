/** What a map may be made of: parameters with ranges to begin with, and observables. */

import { checkStrings } from "../model/case.js";
import { brokenRule, InputError, rangeOf, unknown } from "../model/rules.js";
import { problemWith } from "../page/entry.js";
import { besideUnit, inProse, shownUnit } from "../page/unit_text.js";
import { t } from "../strings.js";

/** @typedef {import("../kernels/memory.js").Layout} Layout */
/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("../model/registry.js").Varied} Varied */

/**
 * One axis: the parameter that varies along it, its first and last value [SI], and whether values
 * are spaced evenly in their logarithm.
 * @typedef {{name: string, low: number, high: number, log: boolean}} Span
 *
 * An axis as a page asks for it; null, and what is left out, stand for what is usual.
 * @typedef {{[K in keyof Span]?: Span[K] | null} | null} Asked
 *
 * What ranges depend on: the parameters that do not vary, and the sweep of a scenario, if any.
 * @typedef {{options: Record<string, any>, sweep: any}} Origin
 *
 * An observable with its parameters.
 * @typedef {{name: string, parameters: Record<string, number | boolean>}} Watched
 *
 * What colours may show; `together` are those that are computed with the others that have it.
 * @typedef {{name: string, label: string, symbol: string, unit: string, description: string,
 *   together: boolean}} Choice
 */

// A logarithmic axis begins at this share of its end where nothing else is known.
const LOG_SPAN = 0.01;
// Amplitudes reach to this share of the length where nothing else is known.
const AMPLITUDES = 0.5;
const OWNERS = ["system", "drive", "noise", "run"];
// What goes to the right, and which parameters are the axes where nothing else is known.
const FREQUENCIES = ["frequency_ratio", "drive_frequency"];
const FIRST = ["drive_amplitude", "vertical_amplitude", "frequency_ratio", "initial_angle",
  "initial_angular_velocity"];

/** Return whether a parameter belongs to balls on strings. @param {string} name */
export const isOfStrings = (name) => /^(string_restitution|initial_distance)/.test(name);

/**
 * Return the names of the parameters that a map can vary.
 * @param {Registry} registry
 * @param {Record<string, any>} options
 * @returns {string[]}
 */
export function variedBy({ systems, drives, axes, noise_axes: noise }, options) {
  const own = [...systems[options.system].axes ?? [], ...drives[options.drive].axes ?? [],
    ...(options.noise_strength === undefined ? [] : noise)]
    .filter((name) => options.suspension === "string" || !isOfStrings(name));
  return own.sort((a, b) => OWNERS.indexOf(axes[a].owner) - OWNERS.indexOf(axes[b].owner));
}

/**
 * Return the length of the right ball, or of the only one [m].
 * @param {Record<string, any>} options
 * @returns {number}
 */
export function lengthOf(options) {
  return options.length ?? options.right_length;
}

/**
 * Return the options of the drive of a map that has none: the middle of a sweep over drives, else
 * a gentle one.
 * @param {Origin} origin
 */
export function gentleDrive({ options, sweep }) {
  const middle = (/** @type {string} */ name, /** @type {number} */ usual) => {
    const values = sweep?.axes[name];
    return values ? 0.5 * (Math.min(...values) + Math.max(...values)) : usual;
  };
  const length = lengthOf(options);
  return { drive: "harmonic", drive_amplitude: middle("drive_amplitude", 0.1 * length),
    drive_frequency: middle("frequency_ratio", 2) * Math.sqrt(options.gravity / length) };
}

/**
 * Return both axes, x first: those asked for, those of a sweep, or amplitude over frequency.
 * @param {Registry} registry
 * @param {Origin} origin
 * @param {[Asked, Asked]} asked
 * @returns {[Span, Span]}
 */
export function axisSpans(registry, origin, asked) {
  const known = variedBy(registry, origin.options);
  const setBy = (/** @type {string} */ name) => registry.axes[name].sets;
  const usual = Object.keys(origin.sweep?.axes ?? {}).filter((name) => known.includes(name)).slice(0, 2);
  for (const name of [...FIRST, ...known])
    if (usual.length < 2 && known.includes(name) && !usual.some((each) => setBy(each) === setBy(name)))
      usual.push(name);
  const [y, x] = usual.sort((a, b) =>
    Number(FREQUENCIES.includes(a)) - Number(FREQUENCIES.includes(b)));
  const chosen = [x, y].map((own, k) => {
    const name = asked[k]?.name ?? own;
    if (!known.includes(name))
      throw unknown("parameter", name, known);
    return checked(registry.axes[name], spanOf(registry, origin, name, asked[k]), k === 0 ? "x" : "y");
  });
  const [a, b] = chosen.map(({ name }) => registry.axes[name].label);
  if (setBy(chosen[0].name) === setBy(chosen[1].name))
    throw new InputError(a === b ? t("refuseSameAxes", { label: a }) : t("refuseSameThing", { one: a, other: b }));
  return [chosen[0], chosen[1]];
}

/**
 * Return an axis; ends that are not given are those to begin with, and a logarithmic one begins two
 * decades below its end.
 * @param {Registry} registry
 * @param {Origin} origin
 * @param {string} name
 * @param {Asked} asked
 * @returns {Span}
 */
function spanOf(registry, origin, name, asked) {
  const [least, most] = suggestedRange(registry, origin, name);
  const high = asked?.high ?? most;
  const log = asked?.log ?? false;
  const low = asked?.low ?? (log && !(least > 0) && high > 0 ? LOG_SPAN * high : least);
  return { name, low, high, log };
}

/**
 * Return an axis, or throw in the words of the quantity along it.
 * @param {Varied} about
 * @param {Span} span
 * @param {"x" | "y"} which
 */
function checked(about, span, which) {
  const { label, units: [unit] } = about;
  const [first, last] = [`${which}low`, `${which}high`];
  const words = (/** @type {number} */ value) => besideUnit(inProse(value / unit.size), shownUnit(unit.name));
  if (!(span.low < span.high))
    throw new InputError(t("refuseOrder", { label, low: words(span.low), high: words(span.high) }),
      { fields: [first, last] });
  for (const [field, value] of /** @type {[string, number][]} */ ([[first, span.low], [last, span.high]])) {
    const problem = problemWith(span.name, about, { label, unit }, value);
    if (problem !== null) throw new InputError(problem, { fields: [field] });
  }
  if (span.log && !(span.low > 0))
    throw new InputError(t("refuseLog", { label, low: words(span.low) }), { fields: [first] });
  return span;
}

/**
 * Return a range to begin with, inside what is allowed [SI].
 * @param {Registry} registry
 * @param {Origin} origin
 * @param {string} name
 * @returns {[number, number]}
 */
export function suggestedRange(registry, { options, sweep }, name) {
  const values = sweep?.axes[name];
  if (values && Math.min(...values) < Math.max(...values))
    return [Math.min(...values), Math.max(...values)];
  if (/^(drive|vertical|horizontal)_amplitude$/.test(name)) return [0, AMPLITUDES * lengthOf(options)];
  if (name.startsWith("initial_distance")) {
    const length = name.endsWith("left") ? options.left_length : lengthOf(options);
    return [0.5 * length, length];
  }
  if (name === "amplitude_ratio") return [0, AMPLITUDES];
  const about = registry.axes[name];
  const [low, high] = about.suggested ?? around(options[name]);
  const [lower, upper] = rangeOf(about.limits);
  const [least, most] = [Math.max(low, lower?.end ?? -Infinity), Math.min(high, upper?.end ?? Infinity)];
  const inside = 0.01 * (most - least);
  return [least + (lower?.is_open && least === lower.end ? inside : 0),
    most - (upper?.is_open && most === upper.end ? inside : 0)];
}

/**
 * Return a range about a value.
 * @param {any} value
 */
function around(value) {
  if (typeof value !== "number" || !value) return [0, 1];
  return value > 0 ? [0.5 * value, 1.5 * value] : [1.5 * value, 0.5 * value];
}

/**
 * The observables computed at each point, the variable shown, and the others that colours may
 * show: what the sweep of a scenario gathers, or the usual three, is gathered together, anything
 * else alone.
 * @param {Registry} registry
 * @param {Layout} layout
 * @param {Origin} origin
 * @param {string | null} asked
 * @returns {{watched: Watched[], shown: string, choices: Choice[]}}
 */
export function watchedOf(registry, layout, { options, sweep }, asked) {
  const { suspension = "rod" } = options;
  const { angles } = registry.systems[options.system];
  const about = Object.values(layout.observables).find(({ widths }) => asked !== null && asked in widths);
  if (about?.of_strings) checkStrings(suspension, String(asked));
  if (suspension === "string" && about?.needs.includes("compression"))
    throw brokenRule("of_rods", { parameter: String(asked) });
  const fits = (/** @type {string} */ name) => mappable(layout, name, angles, suspension);
  /** @type {any[]} */
  const entries = sweep?.observables ?? registry.default_observables;
  const own = entries.map((each) => observable(registry, each))
    .filter(({ name }) => fits(name).length);
  const names = [...own.map(({ name }) => name), ...Object.keys(layout.observables)];
  /** @type {Map<string, Choice & {owner: string}>} */
  const choices = new Map();
  for (const owner of new Set(names)) {
    const { description, variables } = registry.observables[owner];
    for (const name of fits(owner)) {
      if (choices.has(name)) continue;
      const { label, symbol, unit } = variables[name];
      choices.set(name, { name, label, symbol, unit, description, owner,
        together: own.some((each) => each.name === owner) });
    }
  }
  const known = [...choices.keys()];
  const shown = asked ?? known[0];
  const choice = choices.get(shown);
  if (!choice) throw unknown("observable", shown, known);
  return { watched: choice.together ? own : [{ name: choice.owner, parameters: {} }], shown,
    choices: [...choices.values()].map(({ owner, ...rest }) => rest) };
}

/**
 * Return an observable of a sweep, whose entry is its name, that of one of its variables, or a table.
 * @param {Registry} registry
 * @param {any} entry
 * @returns {Watched}
 */
function observable({ observables }, entry) {
  if (typeof entry !== "string") {
    const { kind, ...parameters } = entry;
    return { name: kind, parameters };
  }
  const owner = Object.keys(observables).find((name) => entry in observables[name].variables);
  return { name: entry in observables ? entry : owner ?? entry, parameters: {} };
}

/**
 * Return the variables of an observable that are one number a point, or start with one.
 * @param {Layout} layout
 * @param {string} name
 * @param {number} angles
 * @param {string} suspension
 */
function mappable({ observables }, name, angles, suspension) {
  const about = observables[name];
  if (!about || (about.angles && about.angles !== angles)) return [];
  if (suspension === "string" ? about.needs.includes("compression") : about.of_strings) return [];
  return Object.keys(about.widths).filter((each) =>
    ["", "exponent"].includes(about.dimension) || about.plain.includes(each));
}
