/** From a preset and options, with units or without, to numbers in SI units. */

import { brokenRule, checkedNumber, eachOf, eitherOf, suggest, unknown } from "./rules.js";
import { toSi } from "./units.js";

/** @typedef {import("./registry.js").Registry} Registry */
/** @typedef {import("./registry.js").Option} Option */
/** @typedef {{scenario?: string | null, options?: Record<string, any>}} OptionsRequest */

/**
 * Return several quantities as numbers in SI units.
 * @param {Registry} registry
 * @param {string} name
 * @param {any} value
 * @param {string} unit
 */
function toSiList(registry, name, value, unit) {
  if (typeof value !== "string") {
    if (!Array.isArray(value) && !ArrayBuffer.isView(value)) return value;
    return Array.from(/** @type {any} */ (value), (part, i) => toSi(registry, `${name}[${i}]`, part, unit));
  }
  const parts = value.split(",").map((part) => part.trim()).filter(Boolean);
  const plain = parts.map((part) => part !== "" && Number.isFinite(Number(part)) ? Number(part) : null);
  // A 0 needs no unit.
  if (plain.includes(null) && plain.some((number) => number))
    throw brokenRule("units_of_list", { parameter: name, value });
  return parts.map((part) => toSi(registry, name, part, unit));
}

/**
 * Return the value of an option: of a text the number, the numbers, the switch or the word.
 * @param {Registry} registry
 * @param {string} name
 * @param {any} value
 */
export function valueOf(registry, name, value) {
  const option = registry.options[name];
  const { unit } = option;
  if (option.several) return toSiList(registry, name, value, unit);
  if (option.switch) {
    const read = { true: true, false: false }[String(value).trim().toLowerCase()];
    if (read === undefined) throw brokenRule("switch", { parameter: name, value });
    return read;
  }
  if (option.whole && typeof value === "string" && /^\s*[-+]?\d{1,15}\s*$/.test(value)) return Number(value);
  if (!unit) return value;
  const isList = Array.isArray(value) || (typeof value === "string" && value.includes(","));
  return option.for_each_ball && isList
    ? toSiList(registry, name, value, unit) : toSi(registry, name, value, unit);
}

/**
 * Return all options that a request sets, in SI units: those of its preset and those that replace
 * them, as `latolato.scenario.scenario.overridden` does.
 * @param {Registry} registry
 * @param {OptionsRequest} request
 * @returns {Record<string, any>}
 */
export function optionsOf(registry, { scenario = null, options = {} }) {
  const known = Object.keys(registry.options);
  /** @type {Record<string, any>} */
  const input = {};
  for (const [name, value] of Object.entries(options)) {
    if (!known.includes(name)) throw unknown("option", name, known);
    if (value === null || value === undefined) continue;
    if (typeof value === "object" && !Array.isArray(value) && !ArrayBuffer.isView(value))
      throw brokenRule("text_or_number", { parameter: name, value });
    if (Array.isArray(value) && value.some((part) => part === null || typeof part === "object"))
      throw brokenRule("quantities", { parameter: name });
    input[name] = valueOf(registry, name, value);
  }
  const presets = Object.keys(registry.scenarios);
  if (scenario && !presets.includes(scenario))
    throw brokenRule("unknown_scenario", {}, { name: scenario, hint: suggest(scenario, presets) });
  if (!scenario && !("system" in input))
    throw brokenRule("what_to_run", {}, { systems: Object.keys(registry.systems).join(", ") });
  let kept = scenario ? registry.scenarios[scenario].given : {};
  const owned = (/** @type {string} */ name) => registry.options[name].owner === "drive";
  if (Object.keys(input).some(owned) && (kept.drive ?? "fixed_pivot") === "fixed_pivot")
    input.drive ??= "harmonic";
  kept = withoutForeign(registry, kept, input);
  return { ...withoutAlternatives(registry, kept, Object.keys(input)), ...input };
}

/**
 * Return options without those that cannot be given beside these, such as a frequency beside its ratio.
 * @template T
 * @param {Pick<Registry, "alternatives">} registry
 * @param {Record<string, T>} options
 * @param {string[]} names
 * @returns {Record<string, T>}
 */
export function withoutAlternatives({ alternatives }, options, names) {
  const replaced = alternatives.filter((group) => group.some((name) => names.includes(name))).flat();
  return without(options, (name) => replaced.includes(name) && !names.includes(name));
}

/**
 * @template T
 * @param {Record<string, T>} values
 * @param {(name: string) => boolean} isLeftOut
 * @returns {Record<string, T>}
 */
function without(values, isLeftOut) {
  return Object.fromEntries(Object.entries(values).filter(([name]) => !isLeftOut(name)));
}

/**
 * Return a preset's options without those that another kind of system, drive or contact law does
 * not know.
 * @param {Registry} registry
 * @param {Record<string, any>} kept
 * @param {Record<string, any>} input
 */
function withoutForeign(registry, kept, input) {
  let values = kept;
  for (const part of /** @type {const} */ (["system", "drive"])) {
    const kind = input[part];
    if (kind === undefined) continue;
    const laws = registry[`${part}s`];
    if (typeof kind !== "string")
      throw brokenRule("kind_of_law", { value: kind }, { part: { word: part } });
    if (!Object.hasOwn(laws, kind))
      throw unknown(part, kind, Object.keys(laws));
    if (kind === kept[part]) continue;
    const own = laws[kind].options;
    values = without(values, (name) => registry.options[name].owner === part && name !== part
      && !own.includes(registry.ratios[name] ?? name));
  }
  if ("contact" in input && input.contact !== kept.contact) {
    const ofLaws = Object.values(registry.contact_laws).flatMap((law) => law.options);
    values = without(values, (name) => ofLaws.includes(name));
  }
  return values;
}

/**
 * Return the parts of all options by their owner.
 * @param {Registry} registry
 * @param {Record<string, any>} options in SI units
 */
export function partsOf(registry, options) {
  /** @type {Record<"system" | "drive" | "run" | "noise", Record<string, any>>} */
  const parts = { system: {}, drive: {}, run: {}, noise: {} };
  for (const [name, value] of Object.entries(options))
    if (name !== "system" && name !== "drive") parts[registry.options[name].owner][name] = value;
  return parts;
}

/**
 * Put frequencies in the place of a drive's frequency ratios.
 * @param {Registry} registry
 * @param {string} kind of the drive
 * @param {Record<string, any>} drive its options
 * @param {number} naturalFrequency [rad/s]
 */
export function withoutRatios(registry, kind, drive, naturalFrequency) {
  for (const [ratio, name] of Object.entries(registry.ratios)) {
    if (!(ratio in drive)) continue;
    if (!registry.drives[kind].options.includes(name)) throw foreign(registry, "drive", kind, name, ratio);
    if (name in drive)
      throw brokenRule("either", { parameter: ratio }, { name });
    const value = drive[ratio];
    delete drive[ratio];
    const several = registry.options[ratio].several;
    if (several && !Array.isArray(value))
      throw brokenRule("numbers", { parameter: ratio, value });
    const numbers = (several ? value : [value]).map((/** @type {any} */ number) =>
      checkedNumber(registry.options[ratio], ratio, number) * naturalFrequency);
    drive[name] = several ? numbers : numbers[0];
  }
}

/**
 * Return the error of an option that belongs to other laws.
 * @param {Registry} registry
 * @param {"system" | "drive"} part
 * @param {string} kind
 * @param {string} name
 * @param {string} [called] what the option was given as
 */
export function foreign(registry, part, kind, name, called = name) {
  const { path } = registry.options[name];
  const laws = registry[`${part}s`];
  const owns = (/** @type {string} */ each) => laws[each].options.some((own) =>
    registry.options[own].path[0] === path[0]);
  const inside = laws[kind].options.filter((own) => registry.options[own].path[1] === path[0]);
  if (inside.length) {
    const parts = eachOf(inside);
    return brokenRule("of_each_part", { parameter: path[0] }, { law: { word: laws[kind].title }, parts });
  }
  const inner = path[1] ?? "";
  const knows = laws[kind].options.some((own) => registry.options[own].path[0] === inner);
  return brokenRule(knows ? "foreign_part" : "foreign", { parameter: called },
    { part: { word: part }, owners: eitherOf(Object.keys(laws).filter(owns)), kind: { word: kind }, name: inner });
}
