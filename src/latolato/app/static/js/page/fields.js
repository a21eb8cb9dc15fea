/** Small fields: a number in one unit, a choice. */

import { el, freshId, refresh } from "./dom.js";
import { Knob } from "./knob.js";

/** @typedef {{unit: string, units: {name: string, size: number}[]}} Shown the SI unit and those on show */

/**
 * Return a knob without a slider that shows the first unit of a quantity and reads any that is known.
 * @param {import("../model/registry.js").Registry} registry
 * @param {string} label
 * @param {Shown} quantity
 * @param {(value: number | null, text: string) => void} take called with SI units, null for no single number
 * @param {{hint?: string, mayBeEmpty?: boolean, isList?: boolean}} [how]
 */
export function numberField(registry, label, { unit, units }, take, { hint = "", ...how } = {}) {
  const option = { label, symbol: "", description: hint, unit, units: units.slice(0, 1), limits: [], low: null, high: null,
    suggested: null, several: false, whole: false, choices: [], switch: false, default: null, usual: null };
  return new Knob(label, option, { ...how, digits: 4, registry, take: (text, value) => take(value, text) });
}

/**
 * Return a select with its label, and what fills it.
 * @param {string} label
 * @param {(value: string) => void} change
 * @param {{isBeside?: boolean}} [how] whether the select stands beside its label, not below it
 */
export function choice(label, change, { isBeside = false } = {}) {
  const id = freshId();
  const select = el("select", { id, on: { change: () => change(select.value) } });
  const root = el("div", { class: isBeside ? "field choice" : "field preset" }, el("label", { for: id }, label), select);
  /**
   * Show these entries, of which one is chosen.
   * @param {{value: string, text: string, title?: string, group?: string}[]} entries
   * @param {string} value
   */
  const show = (entries, value) => {
    refresh(select, entries, () => [...new Set(entries.map((e) => e.group ?? ""))].flatMap((group) => {
      const own = entries.filter((e) => (e.group ?? "") === group)
        .map((e) => el("option", { value: e.value, title: e.title ?? "" }, e.text));
      return group ? [el("optgroup", { label: group }, ...own)] : own;
    }));
    select.value = value;
  };
  return { root, select, show };
}
