/** Errors in the words of the pages. */

import { InputError } from "./rules.js";

/**
 * Return the text of an error, and the option that it is about: the text calls it by its label.
 * @param {import("./registry.js").Registry} registry
 * @param {Error} error
 * @returns {[string, string | null]}
 */
export function inPagesWords(registry, error) {
  if (!(error instanceof InputError) || error.parameter === null) return [error.message, null];
  const [name] = error.parameter.split("[");
  const option = registry.options[name];
  return option ? [error.worded(`\u201c${option.label}\u201d`), name] : [error.message, null];
}
