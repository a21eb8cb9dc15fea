/** What people type into fields: one number, or several, each with a unit or without. */

import { checkedNumber, InputError } from "../model/rules.js";
import { splitQuantity, toSi } from "../model/units.js";
import { capitalised, local, localList, t } from "../strings.js";
import { inPagesWords, sentenceInLanguage } from "./refusals.js";
import { short, shownUnit } from "./unit_text.js";

/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("./option_texts.js").FieldOption} FieldOption */
/** @typedef {import("./unit_text.js").Unit} Unit */
/**
 * What a field takes: numbers in `usual` where they name no unit, or in another unit that converts to
 * the SI unit `unit`; `shown` is a phrase for the usual one, such as "per second". `isList` says whether
 * several numbers may be given: those without a unit have that of the last one. `mayBeEmpty` says whether
 * none need be given; `example` is the text of a number that would do.
 * @typedef {{registry: Pick<Registry, "units" | "prefixes">, usual: Unit, unit: string, shown?: string,
 *   isList?: boolean, mayBeEmpty?: boolean, example?: string}} Takes
 *
 * What was read: values in SI units and their text, with units and decimal points, or what is wrong.
 * @typedef {{values: number[], text: string, problem: null}
 *   | {values: number[], text: string, problem: string}} Entry
 */

/**
 * Return a typed text with decimal points. Where one number belongs, a comma between digits is a
 * decimal comma. In a list commas separate, as they do in addresses, files and Python; semicolons
 * separate too, and then commas are decimal ones.
 * @param {string} text
 * @param {boolean} [isList]
 * @returns {string}
 */
export function withPoints(text, isList = false) {
  const plain = text.trim().replaceAll("−", "-");
  if (!isList) return plain.replace(/^([-+]?\d*),(?=\d)/, "$1.");
  return plain.includes(";") ? plain.split(";").map((part) => withPoints(part)).join(", ") : plain;
}

/**
 * Read what was typed: the rule of all fields for numbers.
 * @param {string} typed
 * @param {Takes} takes
 * @returns {Entry}
 */
export function readEntry(typed, takes) {
  const { usual, isList = false, mayBeEmpty = false, example = "" } = takes;
  const wrong = (/** @type {string} */ problem) => ({ values: [], text: "", problem });
  if (!typed.trim()) {
    if (mayBeEmpty) return { values: [], text: "", problem: null };
    return wrong(example ? t("numberNeeded", { example }) : t("numberNeededHere"));
  }
  const pointed = withPoints(typed, isList);
  const phrase = takes.shown ?? "";
  const parts = (isList ? pointed.split(",") : [pointed]).map((part) => part.trim())
    .map((part) => (phrase && part.endsWith(phrase) ? part.slice(0, -phrase.length).trim() : part));
  const unit = usual.name === "1" ? "" : usual.name;
  const last = splitQuantity(parts[parts.length - 1])?.unit || unit;
  const texts = parts.map((part) => (splitQuantity(part)?.unit === "" ? `${part} ${last}`.trim() : part));
  const read = texts.map((text) => readQuantity(takes.registry, text, takes.unit));
  const values = read.map(({ value }) => value);
  const k = values.findIndex(Number.isNaN);
  if (k >= 0) {
    const [text, shown] = [isList && parts[k] ? local(parts[k]) : typed.trim(), shownUnit(unit)];
    const isLarge = read[k].isLarge;
    const problem = !isLarge && phrase ? t("noNumberOf", { text, unit: phrase })
      : t(isLarge ? "tooLarge" : shown ? "noNumberIn" : "noNumber", { text, unit: shown });
    return wrong([problem, read[k].wayOut].filter(Boolean).join(" "));
  }
  return { values, problem: null, text: texts.join(", ") };
}

/**
 * Read a number, a list of numbers, or a range such as 1.4 : 3.2 : 7, which ends with a count.
 * @param {string} typed
 * @param {Takes} takes
 * @returns {Entry}
 */
export function readRange(typed, takes) {
  const parts = typed.split(":");
  const count = parts.splice(2).map((part) => part.trim());
  const entries = parts.map((part) => readEntry(part, { ...takes, isList: parts.length === 1 }));
  const bad = entries.find(({ problem }) => problem !== null);
  return bad ?? { values: entries.flatMap(({ values }) => values), problem: null,
    text: [...entries.map(({ text }) => text), ...count].join(" : ") };
}

/**
 * Return a list or a range of numbers as its field shows it.
 * @param {string} text
 * @param {{registry: Pick<Registry, "units" | "prefixes">, unit: string, usual: Unit}} takes the SI unit,
 *   and the unit on show
 */
export function shownNumbers(text, { registry, unit, usual: { size } }) {
  const parts = text.split(":");
  const count = parts.splice(2).map((part) => part.trim());
  const shown = (/** @type {string} */ part) => {
    const { value } = readQuantity(registry, part, unit);
    return Number.isNaN(value) ? "?" : short(value / size);
  };
  return [...parts.map((part) => localList(part.split(",").map(shown))), ...count].join(" : ");
}

/**
 * Return a quantity in SI units; NaN with a sentence about what may be meant for a text that is none, and NaN
 * for a number that is too large for a computer.
 * @param {Pick<Registry, "units" | "prefixes">} registry
 * @param {string} text
 * @param {string} unit the SI unit
 * @returns {{value: number, isLarge?: boolean, wayOut?: string}}
 */
export function readQuantity(registry, text, unit) {
  try {
    const value = toSi(registry, "", text, unit);
    return Number.isFinite(value) ? { value } : { value: NaN, isLarge: !Number.isNaN(value) };
  } catch (error) {
    if (!(error instanceof InputError)) throw error;
    const { wayOut } = error.about;
    return { value: NaN, wayOut: wayOut && capitalised(sentenceInLanguage(wayOut)) };
  }
}

/**
 * Return why an option cannot have a value, in the words and the unit of its field; null if it can.
 * @param {string} name
 * @param {Pick<FieldOption, "unit">} option
 * @param {{label: string, unit: Unit}} field
 * @param {number} value in SI units
 * @returns {string | null}
 */
export function problemWith(name, option, { label, unit }, value) {
  const registry = /** @type {any} */ ({ options: { [name]: { ...option, label, units: [unit] } } });
  try {
    checkedNumber(/** @type {any} */ (option), name, value);
    return null;
  } catch (error) {
    if (!(error instanceof InputError)) throw error;
    return inPagesWords(registry, error)[0];
  }
}
