/** Errors in the words of the pages. */

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
 * Return the text of an error, and the option that it is about: the text calls it by its label.
 * @param {import("./registry.js").Registry} registry
 * @param {Error} error
 * @returns {[string, string | null]}
 */
export function inPagesWords(registry, error) {
  if (!(error instanceof InputError) || error.parameter === null) return [inLanguage(error), null];
  const [name] = error.parameter.split("[");
  const option = registry.options[name];
  return option ? [error.worded(`\u201c${option.label}\u201d`, tr), name] : [inLanguage(error), null];
}
