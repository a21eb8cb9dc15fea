/** Errors in the words of the pages. */

import { short, shownUnit } from "../shared/units.js";
import { tr } from "../strings.js";
import { InputError } from "./rules.js";

/**
 * Return the text of an error in the language of the page; it calls parameters by their names.
 * @param {Error} error
 */
export function inLanguage(error) {
  return error instanceof InputError ? error.worded(String(error.parameter), tr) : tr(error.message);
}

/**
 * Return an error with its numbers in the unit in which people read the option that it is about.
 * @param {import("./registry.js").Option} option
 * @param {InputError} error
 */
function inShownUnit({ unit, units = [] }, error) {
  const [shown] = units;
  const { rule, about } = error;
  if (!shown || shown.size === 1 || !unit) return error;
  const number = (/** @type {string | number} */ value) => short(Number(value) / shown.size);
  const range = new RegExp(`([[(])([-\\d.e+]+|-inf), ([-\\d.e+]+|inf)([\\])]) ${unit}$`);
  if (rule.startsWith(`must be given in ${unit} `))
    return new InputError(rule.replace(`in ${unit} `, `in ${shownUnit(shown.name)} `), about);
  if (!range.test(rule) || typeof about.value !== "number") return error;
  const end = (/** @type {string} */ text) => (text.endsWith("inf") ? text : number(text));
  return new InputError(rule.replace(range, (_, open, low, high, close) =>
    `${open}${end(low)}, ${end(high)}${close} ${shownUnit(shown.name)}`), { ...about,
    value: Number(number(about.value)),
    wayOut: about.wayOut?.replace(/(?<=(than|least|most) )[-\d.e+]+$/, number) });
}

/**
 * Return the text of an error, and the option that it is about: the text calls it by its label, and has
 * numbers in the unit on the screen.
 * @param {import("./registry.js").Registry} registry
 * @param {Error} error
 * @returns {[string, string | null]}
 */
export function inPagesWords(registry, error) {
  if (!(error instanceof InputError) || error.parameter === null) return [inLanguage(error), null];
  const [name] = error.parameter.split("[");
  const option = registry.options[name];
  if (!option) return [inLanguage(error), null];
  return [inShownUnit(option, error).worded(`\u201c${option.label}\u201d`, tr), name];
}
