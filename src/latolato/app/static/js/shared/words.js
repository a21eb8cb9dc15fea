/** Refusals of the server in the words of a page. */

// Names of options: those of one word are words of other sentences too, but not as “… must be”.
export const NAMES = /\b[a-z]+(?:_[a-z]+)+\b|^[a-z]+(?= must )/g;

/**
 * Return a refusal with the words of the page for the options that it names.
 * @param {string} text
 * @param {Record<string, {label: string}>} words
 * @returns {string}
 */
export function inWords(text, words) {
  const sentence = withLabels(text, words);
  return sentence.charAt(0).toUpperCase() + sentence.slice(1);
}

/**
 * Return a text with the words of the page for the options that it names.
 * @param {string} text
 * @param {Record<string, {label: string}>} words
 */
export function withLabels(text, words) {
  return text.replace(NAMES, (word) => (word in words ? `“${words[word].label}”` : word));
}
