/** Refusals of the server in the words of a page. */

import { capitalised } from "../strings.js";

// Names of options: those of one word are words of other sentences too, but not as “… must be”.
const NAMES = /'([a-z]+(?:_[a-z\d]+)+)'|\b[a-z]+(?:_[a-z\d]+)+\b|^[a-z]+(?= must )/g;

/**
 * Return a refusal with the words of the page for the options that it names; a name without such words stays.
 * @param {string} text
 * @param {Record<string, {label: string}>} words
 * @returns {string}
 */
export function inWords(text, words) {
  const said = withLabels(text, words);
  return said.search(NAMES) === 0 ? said : capitalised(said);
}

/**
 * Return a text with the words of the page for the options that it names.
 * @param {string} text
 * @param {Record<string, {label: string}>} words
 */
export function withLabels(text, words) {
  // A label has quotes of its own.
  return text.replace(NAMES, (word, name = word) => (name in words ? `“${words[name].label}”` : word));
}
