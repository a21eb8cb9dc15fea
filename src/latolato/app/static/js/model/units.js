/** Quantities as people write them, such as "24.5 cm", "20 deg" or "1.6 Hz": see `latolato.scenario.units`. */

import { brokenRule, sentenceOf } from "./rules.js";

/** @typedef {import("./registry.js").Registry} Registry */

const QUANTITY =
  /^\s*([-+]?(?:(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|nan|inf(?:inity)?))\s*((?:1\/)?[^\d\s].*?)?\s*$/i;

/**
 * Return the number and the unit of a text such as "24.5 cm", as they are written; null for another
 * text. The unit may be missing.
 * @param {string} text
 * @returns {{number: string, unit: string} | null}
 */
export function splitQuantity(text) {
  const match = QUANTITY.exec(text.replaceAll("\u2212", "-"));
  return match && { number: match[1], unit: match[2] ?? "" };
}

/**
 * Return a quantity as a number in SI units; what is no text is returned as it is.
 * @param {Pick<Registry, "units" | "prefixes">} registry
 * @param {string} name
 * @param {any} value
 * @param {string} unit
 */
export function toSi(registry, name, value, unit) {
  if (typeof value !== "string") return value;
  const parts = splitQuantity(value);
  const written = parts?.unit ?? "";
  const plain = plainUnit(written);
  if (parts && ["", unit].includes(plain.replaceAll(" ", "*"))) return numberOf(parts.number);
  const [size, powers] = unitOf(registry, plain) ?? [NaN, {}];
  const [unitSize, known] = unitOf(registry, unit === "1" ? "" : unit) ?? [NaN, {}];
  if (!parts || !areAlike(powers, known) || Number.isNaN(size / unitSize))
    throw notInUnits(registry, name, value, written, unit);
  const number = numberOf(parts.number);
  return Number.isFinite(number) ? times(parts.number, String(size / unitSize)) : number * (size / unitSize);
}

/**
 * Return a unit in the letters of SI units such as "m/s^2"; pages show powers and products otherwise.
 * @param {string} unit
 */
function plainUnit(unit) {
  return unit.replace("³ᐟ²", "^(3/2)").replaceAll("²", "^2").replaceAll("³", "^3").replaceAll("·", "*")
    .replaceAll("**", "^").replace(/ per /g, "/");
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
 * @param {Pick<Registry, "units" | "prefixes">} registry
 * @param {string} text
 * @returns {[number, Record<string, number>] | null}
 */
function unitOf({ units, prefixes }, text) {
  let size = 1;
  /** @type {Record<string, number>} */
  const powers = {};
  const parts = text.matchAll(/\s*([*/]?)\s*([a-zA-Z_µμ°%]\w*|1)(?:\^(-?\d+))?/g);
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
  return end === text.length ? [size, powers] : null;
}

/**
 * @param {Pick<Registry, "units" | "prefixes">} registry
 * @param {string} parameter
 * @param {string} value
 * @param {string} written the unit in it
 * @param {string} unit
 */
function notInUnits(registry, parameter, value, written, unit) {
  const meant = written && unit !== "1" ? inOtherLetters(registry, written, unit) : undefined;
  return brokenRule(unit === "1" ? "plain_number" : "quantity_of_unit",
    { parameter, value, ...(meant ? { wayOut: sentenceOf("meant", { name: meant }) } : {}) }, { unit });
}

/**
 * Return the unit that differs in capitals only and converts to `unit`, undefined if there is none.
 * @param {Pick<Registry, "units" | "prefixes">} registry
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
