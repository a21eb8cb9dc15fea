/** The fields of one analysis: what the server says of its options, filled to take seconds. */

import { el, freshId } from "./dom.js";
import { t } from "./strings.js";

/** @typedef {{label: string, description: string, unit: string | null, kind: string,
 *   several: boolean, required: boolean, default: string, choices: string[]}} Field */
/** @typedef {{quick: Record<string, string>, parameters: Record<string, {label: string,
 *   unit: string, low: string, high: string}>}} About what the server says of system and drive */

// The option that says what a diagram varies, and the two that say between which limits.
const VARIED = "parameter";
const LIMITS = ["low", "high"];

/**
 * Return what a field begins with; nothing where a default or the scenario says it.
 * @param {string} name
 * @param {Field} field
 * @param {About} about
 * @param {string | undefined} varied
 * @returns {string}
 */
export function beginning(name, field, about, varied) {
  if (LIMITS.includes(name) && varied !== undefined)
    return about.parameters[varied]?.[/** @type {"low" | "high"} */ (name)] ?? "";
  const quick = about.quick[name];
  if (quick === undefined || (quick.includes(":") && !(field.several && field.required))) return "";
  return quick;
}

export class AnalysisForm {
  /**
   * @param {(values: Record<string, string>) => void} changed called with all that is typed
   */
  constructor(changed) {
    this.changed = changed;
    this.root = el("div", { class: "fields" });
    /** @type {Record<string, HTMLInputElement | HTMLSelectElement>} */
    this.inputs = {};
    /** @type {Record<string, HTMLElement>} */
    this.errors = {};
  }

  /**
   * Show the fields of an analysis.
   * @param {Record<string, Field>} fields
   * @param {About} about
   * @param {Record<string, string>} given what was typed before
   */
  build(fields, about, given) {
    this.inputs = {};
    this.errors = {};
    const varied = VARIED in fields
      ? given[VARIED] ?? (fields[VARIED].default || about.quick[VARIED]) : undefined;
    this.root.replaceChildren(...Object.entries(fields).map(([name, field]) => {
      const value = given[name] ??
        (name === VARIED ? varied : beginning(name, field, about, varied));
      return this.field(name, field, about, value ?? "", varied);
    }));
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
    const choices = name === VARIED ? Object.keys(about.parameters) : field.kind === "bool"
      ? ["false", "true"] : field.choices;
    const unit = field.unit ?? (varied ? about.parameters[varied]?.unit ?? "" : "");
    const placeholder = field.default || t(field.required ? "fromScenario" : "automatic");
    const input = choices.length
      ? el("select", { id }, ...choices.map((each) => el("option", { value: each },
        name === VARIED ? about.parameters[each].label : each)))
      : el("input", { id, type: "text", autocomplete: "off", spellcheck: "false", placeholder,
        "aria-describedby": errorId });
    input.value = value || (choices.length ? field.default || choices[0] : "");
    input.addEventListener("change", () => {
      if (name === VARIED) for (const limit of LIMITS) delete this.inputs[limit];
      this.changed(this.values());
    });
    this.inputs[name] = input;
    const error = el("p", { class: "error", id: errorId, role: "alert", hidden: true });
    this.errors[name] = error;
    return el("div", { class: `field analysis ${field.several ? "several" : ""}` },
      el("label", { for: id, title: field.description }, field.label),
      el("span", { class: "entry" }, input, unit && el("span", { class: "unit" }, unit)),
      el("p", { class: "hint" }, field.description), error);
  }

  /** Return what is typed, by option; empty fields are left out. */
  values() {
    return Object.fromEntries(Object.entries(this.inputs)
      .map(([name, input]) => [name, input.value.trim()]).filter(([, value]) => value !== ""));
  }

  /**
   * Show a refusal beside the field that it names first; returns whether there is one.
   * @param {string | null} text
   */
  error(text) {
    const words = text?.split(/[^\w]+/) ?? [];
    const found = words.find((word) => word in this.inputs);
    for (const [name, place] of Object.entries(this.errors)) {
      place.hidden = name !== found;
      place.textContent = name === found ? text : "";
      this.inputs[name].setAttribute("aria-invalid", String(name === found));
    }
    return found !== undefined;
  }
}
