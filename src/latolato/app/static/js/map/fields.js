/** Small fields of the Map view: a number with its unit, a choice, a switch. */

import { el, freshId } from "../page/dom.js";
import { readEntry } from "../page/entry.js";
import { localShort, shownUnit } from "../page/unit_text.js";

/** @typedef {{unit: string, units: {name: string, size: number}[]}} Shown the SI unit and those on show */

/**
 * Return the line below a field that says what is wrong with it; null takes it away.
 * @param {HTMLInputElement} input
 */
export function problemOf(input) {
  const line = el("p", { class: "error", id: freshId(), role: "alert", hidden: true });
  const show = (/** @type {string | null} */ text) => {
    line.hidden = text === null;
    line.textContent = text ?? "";
    input.setAttribute("aria-invalid", String(text !== null));
    if (text === null) input.removeAttribute("aria-describedby");
    else input.setAttribute("aria-describedby", line.id);
  };
  return { line, show };
}

/** A number field that shows one unit and reads any that is known. */
export class QuantityField {
  /**
   * @param {import("../model/registry.js").Registry} registry
   * @param {string} label
   * @param {(value: number | null) => void} change called with SI units, null for an empty field
   * @param {{hint?: string, mayBeEmpty?: boolean}} [how] `mayBeEmpty` is for one that without a number
   *   shows in grey what it stands for
   */
  constructor(registry, label, change, { hint = "", mayBeEmpty = false } = {}) {
    const id = freshId();
    this.registry = registry;
    this.mayBeEmpty = mayBeEmpty;
    /** What it shows. @type {Shown} */
    this.quantity = { unit: "1", units: [] };
    this.input = el("input", { id, type: "text", inputmode: "decimal", autocomplete: "off",
      spellcheck: "false", on: { change: () => this.read(change) } });
    this.unit = el("span", { class: "unit" });
    this.problem = problemOf(this.input);
    this.seen = "";
    this.example = "";
    /** Whether a value was taken that is not shown yet, and whether the map was refused for this field. */
    this.isNew = this.isRefused = false;
    this.root = el("div", { class: "field" }, el("label", { for: id, title: hint }, label),
      el("span", { class: "entry" }, this.input, this.unit), this.problem.line);
  }

  /**
   * Show a value in SI units; `chosen` says whether it was chosen or stands for the usual one.
   * What could not be read stays, with what is wrong with it, until there is another value.
   * @param {number | null} value
   * @param {Shown} quantity
   * @param {boolean} [chosen]
   */
  show(value, quantity, chosen = true) {
    const { units } = quantity;
    const now = JSON.stringify([value, units[0]?.name]);
    if (!this.problem.line.hidden && now === this.seen) return;
    this.seen = now;
    this.isNew = this.isRefused = false;
    this.quantity = quantity;
    this.unit.textContent = shownUnit(units[0]?.name ?? "");
    const text = value === null ? "" : localShort(value / (units[0]?.size ?? 1), 4);
    this.example = text;
    this.problem.show(null);
    if (document.activeElement === this.input) return;
    this.input.value = chosen ? text : "";
    this.input.placeholder = chosen ? "" : text;
  }

  /** @param {(value: number | null) => void} change */
  read(change) {
    const { registry, quantity: { unit, units }, mayBeEmpty, example } = this;
    const { values: [value = null], problem } = readEntry(this.input.value,
      { registry, usual: units[0] ?? { name: "", size: 1 }, unit, mayBeEmpty, example });
    this.problem.show(problem);
    this.isRefused = false;
    if (problem !== null) return;
    this.isNew = true;
    change(value);
  }

  /**
   * Say why the map of this value was refused; null takes that away, but not what is wrong with the text.
   * @param {string | null} text
   */
  refuse(text) {
    if (text === null && !this.isRefused) return;
    this.isRefused = text !== null;
    this.problem.show(text);
  }
}

/**
 * Return a select with its label, and what fills it.
 * @param {string} label
 * @param {(value: string) => void} change
 */
export function choice(label, change) {
  const id = freshId();
  const select = el("select", { id, on: { change: () => change(select.value) } });
  const root = el("div", { class: "field preset" }, el("label", { for: id }, label), select);
  let shape = "";
  /**
   * Show these entries, of which one is chosen.
   * @param {{value: string, text: string, title?: string, group?: string}[]} entries
   * @param {string} value
   */
  const show = (entries, value) => {
    const now = JSON.stringify(entries);
    if (now !== shape) {
      shape = now;
      const groups = [...new Set(entries.map((e) => e.group ?? ""))];
      const made = (/** @type {{value: string, text: string, title?: string}} */ e) =>
        el("option", { value: e.value, title: e.title ?? "" }, e.text);
      select.replaceChildren(...groups.flatMap((group) => {
        const own = entries.filter((e) => (e.group ?? "") === group).map(made);
        return group ? [el("optgroup", { label: group }, ...own)] : own;
      }));
    }
    select.value = value;
  };
  return { root, select, show };
}

/**
 * Return a box to tick with its label.
 * @param {string} label
 * @param {(on: boolean) => void} change
 */
export function tick(label, change) {
  const box = el("input", { type: "checkbox", on: { change: () => change(box.checked) } });
  const text = el("span", {}, label);
  const root = el("label", { class: "check" }, box, text);
  return { root, box, text };
}
