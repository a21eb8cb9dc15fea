/**
 * The texts of the pages, by name, in the language that the page speaks. Each language is a table in `languages`.
 *
 * A text is a string with gaps, or one for each plural form of its gap `count`.
 * @typedef {string | Record<string, string>} Text
 *
 * A language: its own name, the texts of the pages by their names, and texts that are born as data
 * (titles of presets, labels of parameters, rules of refusals) by the English ones. There a gap
 * stands for whatever the English text has in its place.
 * @typedef {{name: string, beta?: boolean, strings: Record<string, Text>, texts: Record<string, string>}} Language
 */

import { loadJson } from "./kernels/load.js";

export const ENGLISH = "en";
// What a page says until it speaks another language, and where that language lacks a text.
/** @type {Record<string, Text>} */
const STRINGS = (await loadJson(`languages/${ENGLISH}.json`)).strings;
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
  /** Texts with gaps, those with most letters first. @type {{shape: RegExp, gaps: string[], text: string}[]} */
  shapes: [],
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
export function setLanguage(code, { strings, texts }) {
  const letters = (/** @type {string} */ text) => text.replace(GAP, "").length;
  const shapes = Object.keys(texts).filter((text) => text.search(GAP) >= 0)
    .sort((a, b) => letters(b) - letters(a)).map((text) => ({ text: texts[text],
      gaps: Array.from(text.matchAll(GAP), ([, gap]) => gap),
      shape: new RegExp(`^${text.split(GAP).map((part, i) =>
        (i % 2 ? "(.*?)" : part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"))).join("")}$`) }));
  Object.assign(spoken, { code, strings: { ...STRINGS, ...strings }, texts: new Map(Object.entries(texts)),
    shapes, hasComma: new Intl.NumberFormat(code).format(0.5).includes(",") });
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
  const [begun, capital] = [line.charAt(0).toLowerCase(), line.charAt(0).toUpperCase()];
  const label = capital === begun ? undefined : spoken.texts.get(begun + line.slice(1));
  if (label !== undefined) return label.charAt(0).toUpperCase() + label.slice(1);
  for (const { shape, gaps, text: other } of spoken.shapes) {
    const parts = shape.exec(line);
    if (parts) return filled(other, Object.fromEntries(gaps.map((gap, i) => [gap, tr(parts[i + 1])])));
  }
  return text;
}

/**
 * Return numbers with decimal points as the language of the page writes them.
 * @param {string} text
 * @returns {string}
 */
export function local(text) {
  return spoken.hasComma ? text.replace(/(\d)\.(?=\d)/g, "$1,") : text;
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
