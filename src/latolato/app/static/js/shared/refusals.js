/** Errors in the words of the pages. */

import { InputError } from "../model/rules.js";
import { local, tr } from "../strings.js";
import { short, shownUnit } from "./units.js";

/**
 * Return the text of an error in the language of the page; it calls parameters by their names.
 * @param {Error} error
 */
export function inLanguage(error) {
  return error instanceof InputError ? error.worded(String(error.parameter), tr) : tr(error.message);
}

// A range as Python writes it, after what lies in it and what its ends are where they have a name; and the
// plain words for each kind of end.
const RANGE = /^(.*?)must lie (?:in|between (.+)) ([[(])(.+), (.+)([\])])(?: \S+)?$/;
const ENDS = { "[": "at least", "(": "above", "]": "at most", ")": "below" };

/**
 * Return a number as rules write it, also as a multiple of pi; NaN for another text.
 * @param {string | number} text
 */
function numberOf(text) {
  const turns = /^(\d*) ?pi$/.exec(String(text));
  return turns ? Number(turns[1] || 1) * Math.PI : Number(text);
}

/**
 * Return an error in plain words, with its numbers in the unit in which the page shows its option.
 * @param {import("../model/registry.js").Option} option
 * @param {InputError} error
 */
function inPlainWords({ unit, units = [] }, error) {
  const { name, size } = units[0] ?? { name: unit, size: 1 };
  const { rule, about: { wayOut, ...about } } = error;
  const value = typeof about.value === "bigint" ? Number(about.value) : about.value;
  const shown = shownUnit(name);
  const tail = shown && (shown.startsWith("°") ? shown : ` ${shown}`);
  if (/^must be (given in|a number in|given as a plain number)/.test(rule))
    // A phrase such as "per second" is no unit in which numbers are.
    return new InputError(shown && !shown.includes(" ") ? `must be a number in ${shown}` : "must be a number",
      { ...error.about, value });
  const range = RANGE.exec(rule);
  if (!range || typeof value !== "number") return error;
  const number = (/** @type {string | number} */ each) => short(numberOf(each) / size);
  // A range may end at another parameter: [0, length).
  const end = (/** @type {string} */ text) => (!Number.isNaN(numberOf(text)) ? `${number(text)}${tail}`
    : /^[a-z_]+$/.test(text) ? `the ${text.replaceAll("_", " ")}` : `${text}${tail}`);
  const [, before, named, open, low, high, close] = /** @type {any} */ (range);
  const ends = [[low, open], [high, close]].filter(([text]) => !text.endsWith("inf"));
  const isClosed = ends.length === 2 && open + close === "[]" && low !== high;
  const listed = ends.map(([text, mark]) => `${/** @type {any} */ (ENDS)[mark]} ${end(text)}`).join(" and ");
  const plain = isClosed ? `must lie between ${named ? `${named}, ` : ""}${number(low)} and ${end(high)}`
    : `must be ${listed}`;
  // A way out that only repeats an end is left out.
  const isNews = wayOut && !ends.some(([text]) => wayOut.endsWith(` ${text}`));
  return new InputError(before === "{parameter} " ? plain : before + plain, { ...about, value: Number(number(value)),
    ...(isNews ? { wayOut: wayOut.replace(/(?<=(than|least|most) )[-\d.e+]+$/, number) } : {}) });
}

/**
 * Return the text of an error, and the option that it is about: the text calls it by its label, and has
 * numbers in the unit on the screen.
 * @param {import("../model/registry.js").Registry} registry
 * @param {Error} error
 * @returns {[string, string | null]}
 */
export function inPagesWords(registry, error) {
  if (!(error instanceof InputError) || error.parameter === null) return [inLanguage(error), null];
  const [name] = error.parameter.split("[");
  const option = registry.options[name];
  if (!option) return [inLanguage(error), null];
  return [local(inPlainWords(option, error).worded(`\u201c${option.label}\u201d`, tr)), name];
}
