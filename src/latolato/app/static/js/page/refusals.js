/** Errors in the words of the pages. */

import { asRead, InputError, literal, pythonName, say } from "../model/rules.js";
import { capitalised, local, ruleText, t, tr } from "../strings.js";
import { besideUnit, DEGREE, inProse, shownEnd, shownUnit } from "./unit_text.js";

/** What the page calls the parameters for which it has a field or a button. @type {Map<string, string>} */
const LABELS = new Map();
/** What the page calls systems and drives, by their kinds and by the names of their classes. @type {Map<string, string>} */
const KINDS = new Map();
const LANGUAGE = naming({});
// Rules of what is not given.
const NEEDED = ["needed", "needed_by_analysis"];
// Rules that refuse what is no number in the unit of an option.
const NUMBERS = ["number", "number_in_unit", "quantity_of_unit", "plain_number"];
// Rules of the ends of an option's range; those of sizes that can be computed with have a way out of their own.
const LOWER_ENDS = ["at_least", "more_than"];
const OPEN_ENDS = ["more_than", "less_than"];
const ENDS = [...LOWER_ENDS, "at_most", "less_than"];
// Rules of what is beyond numbers that can be computed with, and the texts for them.
const SIZES = /** @type {Record<string, string>} */ ({ size: "refuseTooLarge", turns: "refuseTooLarge", tiny: "refuseTooSmall" });
const RADII = ["radius", "right radius", "left radius"];
// Problems with the start, and the texts for them in the unit on the screen.
const STARTS = /** @type {Record<string, string>} */ ({
  angle: "refuseContact", "angle in degrees": "refuseContact",
  separation: "refuseSeparation", "separation in degrees": "refuseSeparation",
  offset: "refuseOffset", "offset in degrees": "refuseOffset",
  "half turn": "refuseBetween", turn: "refuseTurn" });
// The gap of the parameter at fault: without it a sentence begins with the parameter.
const PLACE = /\{(?:parameter|@)\}/;
const TURNS = /** @type {Record<string, number>} */ ({ "half turn": Math.PI, turn: 2 * Math.PI });

/**
 * Learn what the page calls parameters.
 * @param {Record<string, {label: string}>} options
 */
export function learnLabels(options) {
  for (const [name, { label }] of Object.entries(options)) LABELS.set(name, label);
}

/**
 * Learn what the page calls systems and drives.
 * @param {import("../model/registry.js").Registry} registry
 */
export function learnKinds({ systems, drives }) {
  for (const [kind, { title }] of Object.entries({ ...systems, ...drives }))
    for (const name of [kind, title]) KINDS.set(name, tr(title));
}

/** @param {string} label */
function quoted(label) {
  return `\u201c${label}\u201d`;
}

/**
 * Return what the page calls a parameter, or what sets it to a word or a number.
 * @param {string | undefined} label that of its field, if it has one
 * @param {string} parameter
 * @param {string} [value]
 */
function called(label, parameter, value) {
  if (label === undefined) return pythonName(parameter, value);
  return value === undefined ? quoted(label) : `${quoted(label)} = ${/^\d/.test(value) ? value : quoted(tr(value))}`;
}

/**
 * Return a sentence or a number with its powers of ten as people read them.
 * @param {string} text
 */
export function legible(text) {
  return local(text.replace(/'[^']*'|\b\d+(?:\.\d+)?e[-+]\d+/g, (part) => (part.startsWith("'") ? part : asRead(part))));
}

/**
 * Return the text of an error in the language of the page; it calls parameters by their names.
 * @param {Error} error
 * @param {import("../model/rules.js").RuleLanguage} [language]
 */
export function inLanguage(error, language = LANGUAGE) {
  return error instanceof InputError ? local(error.worded(String(error.parameter), language)) : tr(error.message);
}

/**
 * Return the text of an error as a sentence begins; names of files, and those of Python for what has no label, stay as
 * they are.
 * @param {string} text
 * @param {Error} error
 */
function begun(text, error) {
  if (!(error instanceof InputError)) return capitalised(text);
  const { about: { where }, parameter, rule } = error;
  const isOwn = where === undefined && (parameter === null || PLACE.test(templateOf(rule))) && beginsWithWord(rule);
  return isOwn ? capitalised(text) : text;
}

/** @param {string | import("../model/rules.js").Sentence} rule */
function templateOf(rule) {
  return typeof rule === "string" ? rule : ruleText(rule.name, rule.part) ?? rule.text;
}

/**
 * Return whether a sentence begins with a word of its own, not with what stands in a gap as it was given.
 * @param {string | import("../model/rules.js").Sentence} rule
 * @returns {boolean}
 */
function beginsWithWord(rule) {
  const gap = /^\{(.*?)[:}]/.exec(templateOf(rule))?.[1];
  if (gap === undefined) return true;
  const value = typeof rule === "string" ? undefined : rule.values[gap];
  return typeof value === "object" && ("word" in value || beginsWithWord(value));
}

/**
 * Return the text of an error in the language of the page, as a sentence begins.
 * @param {Error} error
 */
export function sentenceOfError(error) {
  return begun(inLanguage(error), error);
}

/**
 * Return the language of the page, in which options are called by their labels.
 * @param {Record<string, {label: string}>} options
 * @returns {import("../model/rules.js").RuleLanguage}
 */
function naming(options) {
  const labelOf = (/** @type {string} */ name) => (Object.hasOwn(options, name) ? options[name].label : LABELS.get(name));
  return { sentence: ruleText, word: (text) => KINDS.get(text) ?? tr(text),
    given: (value) => listed(value, (each) => {
      const words = KINDS.get(each) ?? labelOf(each);
      return words === undefined ? literal(each) : quoted(words);
    }),
    // Angles of a quantity in a sentence: `latolato.core.errors.quantity_gap`.
    values: (values) => (values.unit === " rad" && typeof values.value === "number"
      ? { ...values, value: values.value / DEGREE, unit: "°" } : values),
    label: (parameter, value) => called(labelOf(parameter), parameter, value) };
}

/**
 * Return what was given in words, the values of a list one after the other.
 * @param {any} value
 * @param {(each: any) => string} words
 * @returns {string}
 */
function listed(value, words) {
  return Array.isArray(value) ? value.map((each) => listed(each, words)).join(", ") : words(value);
}

/**
 * Return a sentence of a rule in the language of the page.
 * @param {string | import("../model/rules.js").Sentence} sentence
 * @param {Record<string, {label: string}>} [options] that have labels of their own here
 */
export function sentenceInLanguage(sentence, options = {}) {
  return legible(say(sentence, naming(options)));
}

/**
 * Return a text that ends like a sentence.
 * @param {string} text
 */
export function stopped(text) {
  return /[.?!]$/.test(text) ? text : `${text}.`;
}

/**
 * Return the warnings of a run as one text; those of the installed program are texts already.
 * @param {(string | import("../model/rules.js").Sentence)[]} warnings
 */
export function warningsText(warnings) {
  return warnings.map((each) => t("warning", { text: stopped(sentenceInLanguage(each)) })).join(" ");
}

/**
 * Return in words where numbers may lie, as "at least 0 m and below 1 m".
 * @param {{end: string, is_open: boolean} | null} least null where there is no end
 * @param {{end: string, is_open: boolean} | null} most
 */
export function endsText(least, most) {
  if (least && most && !least.is_open && !most.is_open && least.end !== most.end)
    return t("endBetween", { low: least.end, high: most.end });
  const texts = [least && t(least.is_open ? "endAbove" : "endAtLeast", { end: least.end }),
    most && t(most.is_open ? "endBelow" : "endAtMost", { end: most.end })].filter((text) => text !== null);
  return texts.length === 2 ? t("endBoth", { one: texts[0], other: texts[1] }) : texts.join("");
}

/**
 * Return the ends of the range that a rule names, null where there is none: those of the option, or the rule's own
 * end where it is no limit of the option.
 * @param {import("../model/registry.js").Option["limits"]} limits
 * @param {import("../model/rules.js").Sentence} rule
 * @returns {({end: number, is_open: boolean} | null)[]}
 */
function endsOf(limits, { name, values }) {
  if (!limits.some(({ rule, values: own }) => rule === name && own.end === values.end)) {
    const end = { end: Number(values.end), is_open: OPEN_ENDS.includes(name) };
    if (Number.isNaN(end.end)) return [null, null];
    return LOWER_ENDS.includes(name) ? [end, null] : [null, end];
  }
  const end = (/** @type {boolean} */ isLower) =>
    limits.find((limit) => limit.is_lower === isLower && ENDS.includes(limit.rule)) ?? null;
  return [end(true), end(false)];
}

/**
 * Return an error in plain words, with its numbers in the unit in which the page shows its option.
 * @param {import("../model/registry.js").Option} option
 * @param {InputError} error
 */
function inPlainWords({ unit, units = [], limits = [] }, error) {
  const { rule, about: { wayOut, ...about } } = error;
  if (typeof rule === "string") return error;
  // Whoever fills in a field sees its unit there.
  if (NEEDED.includes(rule.name)) return new InputError({ ...rule, values: { ...rule.values, unit: "" } }, error.about);
  const { name, size } = units[0] ?? { name: unit, size: 1 };
  const shown = shownUnit(name);
  const value = typeof about.value === "bigint" ? Number(about.value) : about.value;
  const withUnit = (/** @type {number} */ each) =>
    besideUnit(Number.isNaN(each) ? t("asNaN") : inProse(each / size), Number.isFinite(each) ? shown : "");
  if (NUMBERS.includes(rule.name))
    // A phrase such as "per second" is no unit in which numbers are.
    return new InputError(t(shown && !shown.includes(" ") ? "refuseNumberIn" : "refuseNumber", { unit: shown }),
      { ...error.about, value, shown: listed(value, (each) => (typeof each === "number" ? withUnit(each) : literal(each))) });
  if (typeof value !== "number") return error;
  const lower = (/** @type {number} */ end) => withUnit(shownEnd(end / size, true) * size);
  const upper = (/** @type {number} */ end) => withUnit(shownEnd(end / size, false) * size);
  const own = { ...about, shown: withUnit(value) };
  if (rule.name in SIZES) return new InputError(t(SIZES[rule.name]), { ...own, ...(wayOut && { wayOut }) });
  if (ENDS.includes(rule.name)) {
    const [least, most] = endsOf(limits, rule);
    if (!least && !most) return error;
    // The way out of an end only repeats it.
    return new InputError(t("refuseEnds", { ends: endsText(least && { ...least, end: lower(least.end) },
      most && { ...most, end: upper(most.end) }) }), own);
  }
  const { low = 0, high = TURNS[rule.name], length } = rule.values;
  if (rule.name in STARTS)
    return new InputError(t(STARTS[rule.name], { parameter: "{parameter}", low: lower(Number(low)), high: upper(Number(high)) }),
      { ...own, ...(wayOut && { wayOut }) });
  if (RADII.includes(rule.name))
    return new InputError(t("refuseEnds", { ends: endsText({ end: withUnit(0), is_open: false },
      { end: t("endLength", { length: withUnit(Number(length)) }), is_open: true }) }), own);
  return shown ? new InputError(rule, { ...error.about, shown: withUnit(value) }) : error;
}

/**
 * Return the text of an error, as a sentence begins, and the option that it is about: the text calls it by its
 * label, and has numbers in the unit on the screen.
 * @param {import("../model/registry.js").Registry} registry
 * @param {Error} error
 * @returns {[string, string | null]}
 */
export function inPagesWords(registry, error) {
  const { options } = registry;
  const language = naming(options);
  if (!(error instanceof InputError) || error.parameter === null) return [begun(inLanguage(error, language), error), null];
  const [name] = error.parameter.split(/[[ ]/);
  const option = options[name];
  if (!option) {
    // A file's names are those of its columns.
    const own = error.about.where === undefined ? language.label(error.parameter) : error.parameter;
    return [begun(legible(error.worded(own, language)), error), null];
  }
  // Beside its field it needs no name of a file.
  const { where: _, ...about } = error.about;
  const own = inPlainWords(option, new InputError(error.rule, about));
  return [begun(legible(own.worded(quoted(option.label), language)), own), name];
}
