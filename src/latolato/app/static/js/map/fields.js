/** Small fields of the Map view: a number with its unit, a choice, a switch. */

import { el, freshId, tell } from "../dom.js";
import { t } from "../strings.js";
import { short, shownUnit, toSi, parseQuantity } from "../units.js";

/** @typedef {{name: string, size: number}} Unit */

/** A number field that shows one unit and reads any that is known. */
export class QuantityField {
  /**
   * @param {string} label
   * @param {(value: number | null) => void} change called with SI units, null for an empty field
   * @param {string} [hint]
   */
  constructor(label, change, hint = "") {
    const id = freshId();
    /** @type {Unit[]} */
    this.units = [];
    this.input = el("input", { id, type: "text", inputmode: "decimal", autocomplete: "off",
      spellcheck: "false", on: { change: () => this.read(change) } });
    this.unit = el("span", { class: "unit" });
    this.root = el("div", { class: "field" }, el("label", { for: id, title: hint }, label),
      el("span", { class: "entry" }, this.input, this.unit));
  }

  /**
   * Show a value in SI units; `shown` says whether it was chosen or stands for the usual one.
   * @param {number | null} value
   * @param {Unit[]} units
   * @param {boolean} [chosen]
   */
  show(value, units, chosen = true) {
    this.units = units;
    this.unit.textContent = shownUnit(units[0]?.name ?? "");
    this.input.setAttribute("aria-invalid", "false");
    if (document.activeElement === this.input) return;
    const text = value === null ? "" : short(value / (units[0]?.size ?? 1), 4);
    this.input.value = chosen ? text : "";
    this.input.placeholder = chosen ? "" : text;
  }

  /** @param {(value: number | null) => void} change */
  read(change) {
    const text = this.input.value.trim();
    const parsed = parseQuantity(text);
    if (!text) return change(null);
    const value = parsed && parsed.unit === "" ? parsed.number * (this.units[0]?.size ?? 1)
      : toSi(text, this.units);
    const bad = value === null || !Number.isFinite(value);
    this.input.setAttribute("aria-invalid", String(bad));
    if (bad) tell(t("noNumber", { text }));
    else change(value);
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
