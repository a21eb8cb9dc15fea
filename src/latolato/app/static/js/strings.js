/**
 * The texts of the pages, by name, in the language that the page speaks. Each language is a table in `languages`.
 *
 * A text is a string with gaps, or one for each plural form of its gap `count`.
 * @typedef {string | Record<string, string>} Text
 *
 * A language: its own name, its sign between whole numbers and decimals, the texts of the pages by their names, the sentences of rules by the names
 * of the rules, and texts that are born as data (titles of presets, labels of parameters) by the
 * English ones. English has only the sentences that pages say otherwise than Python and the command line.
 * @typedef {{name: string, beta?: boolean, decimal?: string, strings: Record<string, Text>, texts: Record<string, string>,
 *   rules: Record<string, {rule?: string, way_out?: string}>}} Language
 */

import { loadJson } from "./kernels/files.js";

export const ENGLISH = "en";
// What a page says until it speaks another language, and where that language lacks a text.
/** @type {Language} */
const { strings: STRINGS, rules: RULES } = await loadJson(`languages/${ENGLISH}.json`);
const GAP = /\{(\w+)\}/g;

// Gaps that hold names and texts, in which a point between digits is no decimal point.
const NAMES = ["name", "title", "text", "figure", "version", "error", "message", "claimed"];

/** What the page speaks. */
const spoken = {
  code: ENGLISH,
  hasComma: false,
  strings: STRINGS,
  /** @type {Map<string, string>} */
  texts: new Map(),
  rules: RULES,
};

/** Return the code of the language of the page. */
export function languageCode() {
  return spoken.code;
}

/**
 * Speak a language from now on; what is on the page stays as it is.
 * @param {string} code
 * @param {Language} language
 */
export function setLanguage(code, { decimal, strings, texts, rules }) {
  Object.assign(spoken, { code, strings: { ...STRINGS, ...strings }, texts: new Map(Object.entries(texts)),
    rules: { ...RULES, ...rules }, hasComma: decimal === "," });
}

/**
 * Return a text with its gaps filled.
 * @param {string} name
 * @param {Record<string, string | number>} [values]
 * @returns {string}
 */
export function t(name, values = {}) {
  const text = spoken.strings[name];
  if (text === undefined) throw new Error(`there is no text '${name}'`);
  if (typeof text === "string") return filled(text, values);
  const form = new Intl.PluralRules(spoken.code).select(Number(values.count));
  return filled(text[form] ?? text.other, values);
}

/**
 * Return a text that was born as data in the language of the page; as it is where that has none.
 * A label that begins a line, with a capital, is that of the label.
 * @param {string} text in English
 * @returns {string}
 */
export function tr(text) {
  const line = text.replace(/\s+/g, " ").trim();
  const known = spoken.texts.get(line);
  if (known !== undefined) return known;
  const begun = line.charAt(0).toLowerCase() + line.slice(1);
  const label = capitalised(line) === begun ? undefined : spoken.texts.get(begun);
  return label === undefined ? text : capitalised(label);
}

/** @param {string} text */
export function capitalised(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/**
 * Return a sentence of a rule in the words of the page, undefined where they are those of Python.
 * @param {string} rule
 * @param {"rule" | "way_out"} part
 */
export function ruleText(rule, part) {
  return spoken.rules[rule]?.[part];
}

/**
 * Return numbers with decimal points as the language of the page writes them; what stands in quotes is as
 * somebody wrote it.
 * @param {string} text
 * @returns {string}
 */
export function local(text) {
  return spoken.hasComma ? text.replace(/'[^']*'|(\d)\.(?=\d)/g, (all, digit) => (digit ? `${digit},` : all)) : text;
}

/**
 * Return a list of numbers as the language of the page writes it; fields read it back.
 * @param {string[]} numbers
 * @returns {string}
 */
export function localList(numbers) {
  return numbers.map(local).join(spoken.hasComma ? "; " : ", ");
}

/**
 * @param {string} text
 * @param {Record<string, string | number>} values
 */
function filled(text, values) {
  return text.replace(GAP, (_, gap) => {
    const value = String(values[gap]);
    return NAMES.includes(gap) ? value : local(value);
  });
}
