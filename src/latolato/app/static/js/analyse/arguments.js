/** The fields of one analysis, made from what the server says about its options. */

import { el } from "../page/dom.js";
import { Form } from "../page/form.js";
import { inWords } from "../page/option_labels.js";
import { t, tr } from "../strings.js";

/** @typedef {import("../page/option_texts.js").FieldOption} FieldOption */
/** @typedef {FieldOption & {is_from_scenario: boolean, is_in_unit_of_parameter: boolean}} Argument */
/** @typedef {{title: string, options: Record<string, any>, titles: Record<string, string>,
 *   refused: Record<string, {error: string, field: string | null, parts: any}>,
 *   first: Record<string, Record<string, string>>,
 *   parameters: Record<string, {label: string, low: string, high: string,
 *   shown: Pick<FieldOption, "unit" | "units">}>}} SystemAbout
 *   what the server says about system and drive: titles of analyses, why some cannot treat them, texts to begin with, and what diagrams can vary */

// The options that say what a diagram varies, or a curve, and the two that say between which limits.
const ONE = "parameter";
const TWO = "parameters";
const LIMITS = /** @type {const} */ (["low", "high"]);

export class ArgumentForm {
  /**
   * @param {import("../model/registry.js").Registry} registry
   * @param {(values: Record<string, string>) => void} changed called with what was changed
   */
  constructor(registry, changed) {
    this.registry = registry;
    /** The texts on show, and those that the form began with. */
    this.values = /** @type {Record<string, string>} */ ({});
    this.begun = /** @type {Record<string, string>} */ ({});
    /** @type {Record<string, Argument>} */
    this.fields = {};
    /** @type {Record<string, {label: string}>} what options, parameters and analyses are called */
    this.words = {};
    /** What the fields on show are made of: those in which somebody types stay until it changes. */
    this.shape = "";
    this.more = el("details", { class: "inner" });
    this.root = el("div", { class: "settings" });
    this.store = /** @type {any} */ ({ state: { options: this.values }, set: (/** @type {any} */ { options }) => {
      // Other parameters have limits of their own.
      const isOther = this.varies(options) !== this.varies(this.values);
      this.values = this.store.state.options = options;
      if (isOther) for (const limit of LIMITS) delete options[limit];
      this.form.read();
      changed(this.changes());
    } });
    this.form = new Form(el("div", {}), {}, this.store);
    /** The registry with the options of the analysis, for refusals. */
    this.registryInWords = registry;
  }

  /**
   * Show the fields of an analysis.
   * @param {string} name
   * @param {{options: Record<string, Argument>, first: string[]}} analysis
   * @param {SystemAbout} about
   * @param {Record<string, string>} typed what was typed before
   */
  build(name, { options, first }, about, typed) {
    const same = this.name === name;
    this.name = name;
    this.fields = options;
    const analyses = Object.entries(about.titles).map(([each, title]) => [each, { label: tr(title) }]);
    this.words = { ...Object.fromEntries(analyses), ...about.parameters, ...options };
    const defaults = Object.fromEntries(Object.entries(options).filter(([, each]) => each.switch || each.choices.length)
      .map(([each, { default: usual, choices }]) => [each, usual.toLowerCase() || (choices[0] ?? "false")]));
    this.begun = { ...defaults, ...about.first[name] };
    const names = this.varies({ ...this.begun, ...typed });
    const varied = names.split(",").map((each) => about.parameters[each.trim()]).filter((each) => each);
    // The analysis says between which limits what it begins with varies.
    if (varied.length && names !== this.varies(this.begun))
      for (const limit of LIMITS) this.begun[limit] = varied.map((each) => each[limit]).join(", ");
    this.values = this.store.state.options = { ...this.begun, ...typed };
    const shown = explained(Object.fromEntries(Object.entries(options).map(([each, option]) =>
      [each, this.shownAs(each, option, about, varied[0])])));
    const shape = JSON.stringify([shown, first]);
    if (same && shape === this.shape) {
      this.form.read();
      return;
    }
    this.shape = shape;
    const { units, prefixes } = this.registry;
    this.form = new Form(el("div", {}), { units, prefixes, alternatives: [], options: shown }, this.store);
    const known = this.registry.options;
    const parameters = Object.fromEntries(Object.entries(about.parameters)
      .map(([each, { label }]) => [each, { ...known[each], label }]));
    this.registryInWords = { ...this.registry, options: /** @type {any} */ ({ ...known, ...parameters, ...shown }) };
    const field = (/** @type {string} */ each) => {
      const { choices, switch: isSwitch } = shown[each];
      if (each === ONE) return this.form.choiceField(each, shown[each], choices);
      if (each === TWO) return this.form.choicesField(each, shown[each], [t("parameterFirst"), t("parameterSecond")]);
      return choices.length || isSwitch ? this.form.field(each)
        : this.form.numberField(each, shown[each], !LIMITS.some((limit) => limit === each));
    };
    const rest = Object.keys(options).filter((each) => !first.includes(each));
    const open = (same && this.more.open) || rest.some((each) => each in typed);
    this.more = el("details", { class: "inner", open }, el("summary", {}, t("moreSettings")),
      el("div", { class: "fields" }, ...rest.map(field)));
    this.root.replaceChildren(el("div", { class: "fields" }, ...first.map(field)), ...(rest.length ? [this.more] : []));
  }

  /**
   * Return an option as its field shows it.
   * @param {string} name
   * @param {Argument} option
   * @param {SystemAbout} about
   * @param {SystemAbout["parameters"][string] | undefined} varied
   * @returns {Argument}
   */
  shownAs(name, option, about, varied) {
    const placeholder = option.default ? "" : t(option.is_from_scenario ? "fromScenario" : "automatic");
    const labels = { ...option.labels, "": t("automatic") };
    const shown = { ...option, labels, placeholder, takesRange: option.several };
    if (option.is_in_unit_of_parameter && varied) return { ...shown, ...varied.shown };
    if (name !== ONE && name !== TWO) return shown;
    const { parameters } = about;
    return { ...shown, choices: Object.keys(parameters),
      labels: Object.fromEntries(Object.entries(parameters).map(([each, { label }]) => [each, label])) };
  }

  /**
   * Return the names of what is varied, empty where nothing is.
   * @param {Record<string, string>} values
   */
  varies(values) {
    return values[ONE] ?? values[TWO] ?? "";
  }

  /** Whether no limits are missing, as they are once what is varied has changed. */
  get isWhole() {
    return !this.varies(this.values) || LIMITS.every((limit) => limit in this.values);
  }

  /** Whether something that is typed was refused. */
  get isRefused() {
    return [...this.form.fields.values()].some((field) => field.isRefused?.());
  }

  /** The texts that differ from the first ones, by option. */
  changes() {
    return Object.fromEntries(Object.entries(this.values).filter(([name, text]) => text !== this.begun[name]));
  }

  /**
   * Show a refusal beside the field that it is about; returns whether there is such a field.
   * @param {string | null} text
   * @param {string | null} [name] of the option
   */
  error(text, name = null) {
    for (const [each, field] of this.form.fields)
      field.error(each === name && text ? inWords(text, this.words) : null);
    if (this.more.querySelector(".error:not([hidden])")) this.more.open = true;
    // Choices and switches have no place for one.
    return this.root.querySelector(".error:not([hidden])") !== null;
  }
}

/**
 * Return fields with what there is to explain below them: neither their label once more, nor what the field
 * above says already.
 * @param {Record<string, Argument>} fields
 * @returns {Record<string, Argument>}
 */
export function explained(fields) {
  let before = "";
  return Object.fromEntries(Object.entries(fields).map(([name, field]) => {
    const { label, description } = field;
    const repeats = description.toLowerCase().startsWith(label.toLowerCase()) && /^([,;]|$)/.test(description.slice(label.length));
    const rest = repeats ? description.slice(label.length).replace(/^[,;] */, "") : description;
    const isExplained = rest !== "" && description !== before;
    before = description;
    return [name, { ...field, description: isExplained ? rest : description, isExplained }];
  }));
}
