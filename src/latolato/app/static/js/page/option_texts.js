/** Options that belong to systems and drives, and what is kept where these change. */

import { withoutAlternatives } from "../model/options.js";
import { toSi } from "../model/units.js";

/**
 * An option as a field shows it. `placeholder` stands in an empty field, `labels` name choices;
 * `isExplained` says whether its description stands below, `takesRange` whether it may be
 * `low : high : count`.
 * @typedef {{label: string, symbol: string, description: string, unit: string,
 *   units: {name: string, size: number}[], several: boolean, choices: string[], switch: boolean,
 *   whole: boolean, default: any, usual: any, low: number | null, high: number | null,
 *   suggested: [number, number] | null, placeholder?: string, labels?: Record<string, string>,
 *   isExplained?: boolean, takesRange?: boolean, for_each_ball?: boolean}} FieldOption
 */

// Entries of a run that stand in the form, in this order.
export const START = ["initial_angle", "initial_offset", "initial_angular_velocity", "initial_distance", "duration"];

/**
 * Return the options that belong to a choice of system and drive.
 * @param {any} registry
 * @param {string} system
 * @param {string} drive
 * @returns {string[]}
 */
function optionsFor(registry, system, drive) {
  return [...registry.systems[system].options, ...registry.drives[drive].options];
}

/**
 * Return the options of a state that a choice of laws still knows, and a start for those it needs.
 * @param {any} registry
 * @param {Record<string, any>} options
 * @param {Record<string, any>} resolved what the last run had, in SI units
 * @param {string} system
 * @param {string} drive
 * @returns {Record<string, string>}
 */
export function withLaws(registry, options, resolved, system, drive) {
  // An address may name what is not there: the server says so.
  if (!(Object.hasOwn(registry.systems, system) && Object.hasOwn(registry.drives, drive)))
    return /** @type {Record<string, string>} */ ({ ...options });
  const known = optionsFor(registry, system, drive);
  const laws = new Set([
    ...Object.values(registry.systems).flatMap((/** @type {any} */ law) => law.options),
    ...Object.values(registry.drives).flatMap((/** @type {any} */ law) => law.options),
    ...Object.keys(registry.ratios)]);
  /** @type {Record<string, string>} */
  const result = { ...Object.fromEntries(Object.entries(options).filter(([name]) =>
    known.includes(name) || !laws.has(name))), system, drive };
  for (const name of known) {
    const option = registry.options[name];
    if (name in result || name in resolved || option.default !== null) continue;
    result[name] = textOf(registry, name, option.usual ?? option.low ?? 0);
  }
  const two = registry.systems[system].angles === 2;
  const before = result.initial_angle ?? resolved.initial_angle;
  const isTwo = Array.isArray(before) || String(before ?? "").includes(",");
  if (two && !isTwo) Object.assign(result, { initial_angle: "0.4 rad, -0.3 rad" });
  if (two || !registry.systems[system].contacts) delete result.initial_offset;
  if (two !== isTwo) delete result.initial_angular_velocity;
  if (two !== isTwo || (result.suspension ?? resolved.suspension) !== "string" || !known.includes("suspension"))
    delete result.initial_distance;
  if (!two && (isTwo || (before === undefined && !("initial_offset" in result))))
    result.initial_angle = "20 deg";
  return { ...result, ...levelled(registry, result, options, drive) };
}

/**
 * Return options with some of them set, null takes one back, and without what cannot be given beside these.
 * @param {any} registry
 * @param {Record<string, string>} options
 * @param {Record<string, string | null>} changed
 * @returns {Record<string, string>}
 */
export function withOptions(registry, options, changed) {
  // An empty field takes back what it showed, which an alternative may have said.
  const names = Object.keys(changed).filter((name) => changed[name] !== null || !(name in options));
  const kept = Object.entries({ ...withoutAlternatives(registry, options, names), ...changed });
  return /** @type {Record<string, string>} */ (Object.fromEntries(kept.filter(([, value]) => value !== null)));
}

/**
 * Return what changes when balls are hung on rods or strings: what only strings have goes with them; a
 * preset's own value is replaced.
 * @param {Record<string, string>} options
 * @param {Record<string, any>} resolved what the last run had, in SI units
 * @param {string} suspension
 * @returns {Record<string, string | null>}
 */
export function hungOn(options, resolved, suspension) {
  if (suspension !== "rod") return { suspension };
  const hasOwn = options.string_restitution !== undefined;
  return { suspension, initial_distance: null,
    string_restitution: !hasOwn && resolved.string_restitution ? "0" : null };
}

/**
 * Return a drive's lists in the length of the first that was kept: what others begin with has
 * another one.
 * @param {any} registry
 * @param {Record<string, any>} result
 * @param {Record<string, any>} kept
 * @param {string} drive
 * @returns {Record<string, string>}
 */
function levelled(registry, result, kept, drive) {
  const lists = registry.drives[drive].options.filter((/** @type {string} */ name) =>
    registry.options[name].several && name in result);
  const parts = (/** @type {string} */ name) => String(result[name]).split(",").map((p) => p.trim());
  const first = lists.find((/** @type {string} */ name) => name in kept);
  if (!first) return {};
  const { length } = parts(first);
  return Object.fromEntries(lists.map((/** @type {string} */ name) => {
    const own = parts(name);
    return [name, Array.from({ length }, (_, i) => own[Math.min(i, own.length - 1)]).join(", ")];
  }));
}

/**
 * Return the natural frequency that options in SI units make, of a pair that of the right ball
 * [rad/s]; NaN where they lack a length.
 * @param {Record<string, any>} options
 */
export function naturalFrequency({ gravity, length, right_length: right }) {
  return Math.sqrt(gravity / (length ?? right));
}

/**
 * Return a value in SI units as the text of an option: in the unit that fields show first, where that is read as
 * the same numbers.
 * @param {any} registry
 * @param {string} name
 * @param {any} value
 * @returns {string}
 */
export function textOf(registry, name, value) {
  const { unit, units: [usual] } = registry.options[name];
  const values = [value].flat();
  if (usual && usual.name !== "1" && values.every((each) => typeof each === "number")) {
    const texts = values.map((each) => `${Number((each / usual.size).toPrecision(12))} ${usual.name}`);
    if (texts.every((text, i) => toSi(registry, name, text, unit) === values[i])) return texts.join(", ");
  }
  return values.map((each) => typeof each === "number" && unit && unit !== "1" ? `${each} ${unit}` : `${each}`).join(", ");
}

/**
 * Return values in SI units as the texts of options.
 * @param {any} registry
 * @param {Record<string, any>} values
 * @returns {Record<string, string>}
 */
export function textsOf(registry, values) {
  return Object.fromEntries(Object.entries(values).map(([name, value]) => [name, textOf(registry, name, value)]));
}

/**
 * Return the text of an option as a field shows it: what was given, else what the run on show had; null for nothing.
 * @param {any} registry
 * @param {Record<string, string>} own options that were given
 * @param {Record<string, any>} resolved what the last run had, in SI units
 * @param {string} name
 */
export function textIn(registry, own, resolved, name) {
  if (own[name] !== undefined) return own[name];
  const frequency = registry.ratios?.[name];
  if (frequency) {
    const ratio = resolved[frequency] / naturalFrequency(resolved);
    return Number.isFinite(ratio) ? String(ratio) : null;
  }
  const value = resolved[name] ?? registry.options[name].default;
  return value === undefined || value === null ? null : textOf(registry, name, value);
}

/**
 * Return the options given, and beside them what the run on show had of what other laws know: the
 * values of a scenario do not come along by themselves.
 * @param {any} registry
 * @param {Record<string, string>} own
 * @param {Record<string, any>} resolved what the last run had, in SI units
 * @param {{system: string}} before
 * @param {{system: string, drive: string}} after
 * @returns {Record<string, string>}
 */
export function heldOptions(registry, own, resolved, before, { system, drive }) {
  // Where balls begin to touch, a start near the bottom would have them overlap.
  const touching = registry.systems[system].contacts && !registry.systems[before.system]?.contacts;
  const names = [...optionsFor(registry, system, drive), "tolerance", ...(touching ? ["duration"] : START)];
  const result = textsOf(registry, Object.fromEntries(names.map((name) => [name, resolved[name]])
    .filter(([, value]) => value !== undefined && value !== null)));
  return { ...withoutAlternatives(registry, result, Object.keys(own)), ...own };
}
