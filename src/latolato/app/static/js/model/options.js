/** From a preset and options, with units or without, to numbers in SI units. */

import { foreign } from "./laws.js";
import { checkedNumber, InputError, literal, suggest } from "./rules.js";

/** @typedef {import("./registry.js").Registry} Registry */
/** @typedef {import("./registry.js").Option} Option */
/** @typedef {{scenario?: string | null, options?: Record<string, any>}} Request */

const NUMBER =
  /^\s*([-+]?(?:(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|nan|inf(?:inity)?))\s*(\D.*?)?\s*$/i;

/**
 * Return a quantity as a number in SI units; what is no text is returned as it is.
 * @param {Registry} registry
 * @param {string} name
 * @param {any} value
 * @param {string} unit
 */
export function toSi(registry, name, value, unit) {
  if (typeof value !== "string") return value;
  const match = NUMBER.exec(value.replace("\u2212", "-"));
  const unitText = (match?.[2] ?? "").trim();
  const number = match ? numberOf(match[1]) : NaN;
  if (match && (unitText === "" || unitText.replaceAll(" ", "*") === unit)) return number;
  const [size, powers] = unitOf(registry, unitText) ?? [NaN, {}];
  const [unitSize, known] = unitOf(registry, unit === "1" ? "" : unit) ?? [NaN, {}];
  if (!match || !areAlike(powers, known) || Number.isNaN(size / unitSize)) throw notInUnits(registry, name, value, unitText, unit);
  return Number.isFinite(number) ? times(match[1], String(size / unitSize)) : number * (size / unitSize);
}

/**
 * Return the product of two decimal numbers, rounded once.
 * @param {string} one
 * @param {string} other
 */
function times(one, other) {
  let [digits, places] = [1n, 0];
  for (const text of [one, other]) {
    const [number, power = "0"] = text.toLowerCase().split("e");
    const [whole, fraction = ""] = number.replace("+", "").split(".");
    digits *= BigInt(whole.replace("-", "") + fraction);
    places += Number(power) - fraction.length;
  }
  return Number(`${one.startsWith("-") ? "-" : ""}${digits}e${places}`);
}

/** @param {string} text as Python writes numbers */
function numberOf(text) {
  return Number(text.toLowerCase().replace(/inf.*/, "Infinity"));
}

/**
 * Return the size of a unit such as "g*m/s" and its powers of SI units, null if it is not known.
 * @param {Registry} registry
 * @param {string} text
 * @returns {[number, Record<string, number>] | null}
 */
function unitOf({ units, prefixes }, text) {
  let size = 1;
  /** @type {Record<string, number>} */
  const powers = {};
  const plain = text.replaceAll("²", "^2").replaceAll("³", "^3").replaceAll("**", "^");
  const parts = plain.matchAll(/\s*([*/]?)\s*([a-zA-Z_µμ°%]\w*|1)(?:\^(-?\d+))?/g);
  let end = 0;
  for (const part of parts) {
    const [whole, sign, name, power = "1"] = part;
    if (part.index !== end) return null;
    end += whole.length;
    if (name === "1") continue;
    const read = [name, name.replace(/s$/, "")] // "seconds" is one too
      .flatMap((one) => ["", ...Object.keys(prefixes)].map((prefix) => ({ one, prefix })))
      .find((each) => each.one.startsWith(each.prefix)
        && Object.hasOwn(units, each.one.slice(each.prefix.length)));
    if (!read) return null;
    const { one, prefix } = read;
    const [own, bases] = units[one.slice(prefix.length)];
    const times = (sign === "/" ? -1 : 1) * Number(power);
    size *= ((prefixes[prefix] ?? 1) * own) ** times;
    for (const [base, each] of Object.entries(bases)) powers[base] = (powers[base] ?? 0) + times * each;
  }
  return end === plain.length ? [size, powers] : null;
}

/**
 * @param {Registry} registry
 * @param {string} parameter
 * @param {string} value
 * @param {string} written the unit in it
 * @param {string} unit
 */
function notInUnits(registry, parameter, value, written, unit) {
  const rule = unit === "1" ? "as a plain number" : `in ${unit} (or a unit that converts to it)`;
  const meant = written && unit !== "1" ? inOtherLetters(registry, written, unit) : undefined;
  return new InputError(`must be given ${rule}`,
    { parameter, value, ...(meant ? { wayOut: `did you mean '${meant}'?` } : {}) });
}

/**
 * Return the unit that differs in capitals only and converts to `unit`, undefined if there is none.
 * @param {Registry} registry
 * @param {string} written
 * @param {string} unit
 */
function inOtherLetters(registry, written, unit) {
  const [, known] = unitOf(registry, unit) ?? [NaN, {}];
  return Object.keys(registry.units)
    .flatMap((name) => ["", ...Object.keys(registry.prefixes)].map((prefix) => prefix + name))
    .filter((meant) => meant.toLowerCase() === written.toLowerCase())
    .find((meant) => areAlike(unitOf(registry, meant)?.[1] ?? {}, known));
}

/**
 * Return whether two units are of the same powers of SI units, so that one converts to the other.
 * @param {Record<string, number>} one
 * @param {Record<string, number>} other
 */
function areAlike(one, other) {
  return Object.keys({ ...one, ...other }).every((base) => (one[base] ?? 0) === (other[base] ?? 0));
}

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
    throw new InputError("must carry a unit on every value or on none", { parameter: name, value });
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
    if (read === undefined) throw new InputError("must be true or false", { parameter: name, value });
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
 * @param {Request} request
 * @returns {Record<string, any>}
 */
export function optionsOf(registry, { scenario = null, options = {} }) {
  const known = Object.keys(registry.options);
  /** @type {Record<string, any>} */
  const input = {};
  for (const [name, value] of Object.entries(options)) {
    if (!known.includes(name)) throw new InputError(`unknown option '${name}': ${suggest(name, known)}`);
    if (value === null || value === undefined) continue;
    if (typeof value === "object" && !Array.isArray(value) && !ArrayBuffer.isView(value))
      throw new InputError("must be a text or a number", { parameter: name, value });
    if (Array.isArray(value) && value.some((part) => part === null || typeof part === "object"))
      throw new InputError("must be a list of quantities", { parameter: name });
    input[name] = valueOf(registry, name, value);
  }
  const presets = Object.keys(registry.scenarios);
  if (scenario && !presets.includes(scenario))
    throw new InputError(`there is no scenario '${scenario}': ${suggest(scenario, presets)}`);
  if (!scenario && !("system" in input))
    throw new InputError("name what to run: a scenario (`latolato scenarios` lists them), a TOML file, "
      + `--from FILE or --system with one of ${Object.keys(registry.systems).join(", ")}`);
  let kept = scenario ? registry.scenarios[scenario].given : {};
  const owned = (/** @type {string} */ name) => registry.options[name].owner === "drive";
  if (Object.keys(input).some(owned) && (kept.drive ?? "fixed_pivot") === "fixed_pivot")
    input.drive ??= "harmonic";
  kept = withoutForeign(registry, kept, input);
  for (const group of registry.alternatives) {
    const isReplaced = group.some((name) => name in input);
    if (isReplaced) kept = without(kept, (name) => group.includes(name));
  }
  return { ...kept, ...input };
}

/**
 * @param {Record<string, any>} values
 * @param {(name: string) => boolean} isLeftOut
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
      throw new InputError(`the kind of ${part} must be a text, got ${literal(kind)}`);
    if (!Object.hasOwn(laws, kind))
      throw new InputError(`unknown ${part} '${kind}': ${suggest(kind, Object.keys(laws))}`);
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
      throw new InputError(`give either ${name} or {parameter}, got both`, { parameter: ratio });
    const value = drive[ratio];
    delete drive[ratio];
    const several = registry.options[ratio].several;
    if (several && !Array.isArray(value))
      throw new InputError("must be a sequence of numbers", { parameter: ratio, value });
    const numbers = (several ? value : [value]).map((/** @type {any} */ number) =>
      checkedNumber(registry.options[ratio], ratio, number) * naturalFrequency);
    drive[name] = several ? numbers : numbers[0];
  }
}
