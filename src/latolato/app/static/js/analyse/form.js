/** The fields of one analysis, made from what the server says about its options. */

import { el, freshId } from "../shared/dom.js";
import { problemWith, readEntry, readQuantity, withPoints } from "../shared/entry.js";
import { short, shownUnit } from "../shared/units.js";
import { inWords, NAMES } from "../shared/words.js";
import { ENGLISH, localList, t } from "../strings.js";

/** @typedef {import("../shared/units.js").Unit} Unit */
/** @typedef {{label: string, description: string, unit: string, units: Unit[] | null, kind: string,
 *   several: boolean, required: boolean, default: string, choices: Record<string, string>}} Field
 *   numbers without a unit are in SI units; those of `low` and `high` have the units of what varies */
/** @typedef {{title: string, options: Record<string, any>, first: Record<string, Record<string, string>>,
 *   parameters: Record<string, {label: string, units: Unit[], low: string, high: string}>}} About
 *   what the server says about system and drive */

// The option that says what a diagram varies, and the two that say between which limits.
const VARIED = "parameter";
const LIMITS = ["low", "high"];

/**
 * The first texts of the fields, by option.
 * @param {string} name of the analysis
 * @param {Record<string, Field>} fields
 * @param {About} about
 * @param {string | undefined} varied what the diagram varies
 * @returns {Record<string, string>}
 */
export function beginnings(name, fields, about, varied) {
  const texts = { ...about.first[name] };
  if (varied === undefined || !(varied in about.parameters)) return texts;
  for (const limit of LIMITS) if (limit in fields)
    texts[limit] = about.parameters[varied][/** @type {"low" | "high"} */ (limit)];
  return texts;
}

export class AnalysisForm {
  /**
   * @param {import("../model/registry.js").Registry} registry
   * @param {(values: Record<string, string>) => void} changed called with what was changed
   */
  constructor(registry, changed) {
    this.registry = registry;
    this.changed = changed;
    this.root = el("div", { class: "settings" });
    /** @type {Record<string, HTMLInputElement | HTMLSelectElement>} */
    this.inputs = {};
    /** @type {Record<string, HTMLElement>} */
    this.errors = {};
    /** What is wrong with what was typed, and the text that was taken last, by option. */
    this.problems = /** @type {Record<string, string>} */ ({});
    this.taken = /** @type {Record<string, string>} */ ({});
    /** The units that the fields read, by option; they show the first. */
    this.units = /** @type {Record<string, Unit[]>} */ ({});
    /** @type {Record<string, Field>} */
    this.fields = {};
    /** @type {Record<string, string>} */
    this.begun = {};
    /** @type {Record<string, {label: string}>} what options and parameters are called */
    this.words = {};
    this.more = el("details", { class: "inner" });
  }

  /**
   * Show the fields of an analysis.
   * @param {string} name
   * @param {{options: Record<string, Field>, first: string[]}} form
   * @param {About} about
   * @param {Record<string, string>} typed what was typed before
   */
  build(name, { options: fields, first }, about, typed) {
    const same = this.name === name;
    this.name = name;
    this.inputs = {};
    this.errors = {};
    this.problems = {};
    this.taken = {};
    this.fields = fields;
    this.words = { ...about.parameters, ...fields };
    const varied = VARIED in fields
      ? typed[VARIED] ?? about.first[name]?.[VARIED] ?? fields[VARIED].default : undefined;
    this.begun = beginnings(name, fields, about, varied);
    const make = (/** @type {string} */ each) =>
      this.field(each, fields[each], about, typed[each] ?? this.begun[each] ?? "", varied);
    const rest = Object.keys(fields).filter((each) => !first.includes(each));
    const open = (same && this.more.open) || rest.some((each) => each in typed);
    this.more = el("details", { class: "inner", open }, el("summary", {}, t("moreSettings")),
      el("div", { class: "fields" }, ...rest.map(make)));
    this.root.replaceChildren(el("div", { class: "fields" }, ...first.map(make)),
      ...(rest.length ? [this.more] : []));
  }

  /**
   * @param {string} name
   * @param {Field} field
   * @param {About} about
   * @param {string} value
   * @param {string | undefined} varied
   */
  field(name, field, about, value, varied) {
    const id = freshId();
    const errorId = freshId();
    const hintId = freshId();
    /** @type {Record<string, string>} */
    const choices = name === VARIED
      ? Object.fromEntries(Object.entries(about.parameters).map(([key, one]) => [key, one.label]))
      : field.kind === "bool" ? { false: t("no"), true: t("yes") } : field.choices;
    const units = field.units ?? about.parameters[varied ?? ""]?.units ?? [];
    const unit = shownUnit(units[0]?.name ?? "");
    const placeholder = shownIn(this.registry, field.default, units) || t(field.required ? "fromScenario" : "automatic");
    const input = Object.keys(choices).length
      ? el("select", { id, "aria-describedby": hintId }, ...Object.entries(choices)
        .map(([key, label]) => el("option", { value: key }, label)))
      : el("input", { id, type: "text", autocomplete: "off", spellcheck: "false", placeholder,
        "aria-describedby": `${hintId} ${errorId}` });
    input.value = shownIn(this.registry, value, units) || (field.default.toLowerCase() in choices ? field.default.toLowerCase()
      : Object.keys(choices)[0] ?? "");
    // An address may name what is no choice; the server says so.
    if (value && input instanceof HTMLSelectElement && input.value !== value)
      input.prepend(el("option", { value, selected: true }, value));
    input.addEventListener("change", () => {
      if (name === VARIED) for (const limit of LIMITS) delete this.inputs[limit];
      if (input instanceof HTMLSelectElement) this.taken[name] = input.value;
      else if (!this.reads(name, input)) return;
      this.changed(this.changes());
    });
    this.inputs[name] = input;
    this.taken[name] = input instanceof HTMLSelectElement ? input.value : value;
    this.units[name] = units;
    if (input instanceof HTMLInputElement) this.read(name, input.value);
    const error = el("p", { class: "error", id: errorId, role: "alert", hidden: true });
    this.errors[name] = error;
    const long = field.several || input instanceof HTMLSelectElement;
    return el("div", { class: `field analysis ${long ? "several" : ""}` },
      el("label", { for: id }, field.label),
      el("span", { class: "entry" }, input, unit && el("span", { class: "unit" }, unit)),
      el("p", { class: "hint", id: hintId, lang: ENGLISH }, field.description), error);
  }

  /**
   * Take what was typed; returns whether it is what belongs there.
   * @param {string} name
   * @param {HTMLInputElement} input
   */
  reads(name, input) {
    const { text, problem } = this.read(name, input.value);
    this.error(null);
    if (problem !== null) return false;
    this.taken[name] = text;
    input.value = shownIn(this.registry, text, this.units[name]);
    return true;
  }

  /**
   * Read a text in the unit of its field, and note what is wrong with it.
   * @param {string} name
   * @param {string} typed
   * @returns {{text: string, problem: string | null}}
   */
  read(name, typed) {
    const field = this.fields[name];
    const isNumber = ["float", "int"].includes(field.kind);
    const read = isNumber ? this.readNumbers(typed, name)
      : { text: typed.trim(), problem: null };
    if (read.problem === null) delete this.problems[name];
    else this.problems[name] = read.problem;
    return read;
  }

  /**
   * Read a number, a list of numbers, or a range such as 1.4 : 3.2 : 7, which ends with a count. The text
   * names a unit where the field shows another one than that of SI.
   * @param {string} typed
   * @param {string} name
   * @returns {{text: string, problem: string | null}}
   */
  readNumbers(typed, name) {
    const field = this.fields[name];
    const units = this.units[name];
    const [usual = { name: "", size: 1 }] = units;
    const parts = field.several ? typed.split(":") : [typed];
    const isList = field.several && parts.length === 1;
    const count = parts.splice(2);
    // The limits of a diagram have no usual value; an empty field stands for one elsewhere.
    const mayBeEmpty = !LIMITS.includes(name);
    const entries = parts.map((part) => readEntry(part, { registry: this.registry, usual,
      unit: siOf(units), isList, mayBeEmpty, example: shownIn(this.registry, this.begun[name] ?? "", units) }));
    const unfit = (/** @type {number} */ value) =>
      problemWith(name, /** @type {any} */ (field), { label: field.label, unit: usual }, value);
    const texts = usual.size === 1 ? parts.map((part) => withPoints(part, isList)) : entries.map(({ text }) => text);
    return { text: [...texts, ...count.map((part) => part.trim())].join(" : "),
      problem: entries.map(({ problem }) => problem).find((problem) => problem !== null)
        ?? entries.flatMap(({ values }) => values).map(unfit).find((problem) => problem) ?? null };
  }

  /** Whether no limits are missing, as they are once what is varied has changed. */
  get isWhole() {
    return LIMITS.every((limit) => !(limit in this.fields) || limit in this.inputs);
  }

  /** The accepted texts by option, without empty fields. */
  values() {
    return Object.fromEntries(Object.keys(this.inputs).map((name) => [name, this.taken[name]])
      .filter(([, value]) => value !== ""));
  }

  /** The accepted texts that differ from the first ones, by option. */
  changes() {
    return Object.fromEntries(Object.entries(this.values()).filter(([name, value]) =>
      value !== (this.begun[name] ?? this.fields[name].default.toLowerCase()) &&
      !(this.inputs[name] instanceof HTMLSelectElement && !(name in this.begun) &&
        this.fields[name].default === "" && name !== VARIED && value === "false")));
  }

  /**
   * Show a refusal beside the field that it names first, and at others what is wrong with them; returns
   * whether there is such a field.
   * @param {string | null} text
   */
  error(text) {
    const field = text?.match(NAMES)?.find((word) => word in this.inputs);
    for (const [name, place] of Object.entries(this.errors)) {
      const problem = this.problems[name] ?? (name === field && text ? inWords(text, this.words) : "");
      place.hidden = problem === "";
      place.textContent = problem;
      this.inputs[name]?.setAttribute("aria-invalid", String(problem !== ""));
      if (name === field && this.more.contains(place)) this.more.open = true;
    }
    return field !== undefined;
  }
}

/** The SI unit among these. @param {Unit[]} units */
function siOf(units) {
  return units.find(({ size }) => size === 1)?.name ?? "1";
}

/**
 * Return a text as its field shows it: numbers in the first of its units.
 * @param {import("../model/registry.js").Registry} registry
 * @param {string} text
 * @param {Unit[]} units
 */
function shownIn(registry, text, units) {
  const [{ size } = { size: 1 }] = units;
  if (size === 1) return text;
  const parts = text.split(":");
  const count = parts.splice(2);
  const shown = (/** @type {string} */ part) => {
    const { value } = readQuantity(registry, part, siOf(units));
    return Number.isNaN(value) ? part.trim() : short(value / size);
  };
  return [...parts.map((part) => localList(part.split(",").map(shown))), ...count.map((part) => part.trim())].join(" : ");
}
