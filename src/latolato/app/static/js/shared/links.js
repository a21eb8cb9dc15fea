/** Links that lead to another view with other parameters. */

import { el } from "./dom.js";
import { textOf } from "./laws.js";
import { format } from "./state.js";

/** @typedef {import("./state.js").Page} Page */

/**
 * Return a link that opens a state of the page; it can be opened in a new tab too.
 * @param {Page} page
 * @param {{view: string, scenario: string | null, options: Record<string, string>}} target
 * @param {string} text
 * @param {string} [title]
 * @returns {HTMLAnchorElement}
 */
export function openLink(page, target, text, title) {
  return el("a", { href: format({ ...target, extra: {} }), class: "open", title, on: {
    click: (/** @type {MouseEvent} */ event) => {
      if (event.ctrlKey || event.metaKey || event.shiftKey) return;
      event.preventDefault();
      openState(page, target);
    } } }, text);
}

/**
 * Return nothing; the page shows another view, with these parameters.
 * @param {Page} page
 * @param {{view: string, scenario: string | null, options: Record<string, string>}} target
 */
export function openState(page, target) {
  page.store.set(target, "view");
  window.scrollTo(0, 0);
}

/**
 * Return values in SI units as the texts of options.
 * @param {any} registry
 * @param {Record<string, any>} values
 * @returns {Record<string, string>}
 */
export function textsOf(registry, values) {
  return Object.fromEntries(Object.entries(values).map(([name, value]) =>
    [name, textOf(registry.options[name], value)]));
}

// An option that says the same as another one takes its place.
const ALTERNATIVES = [["frequency_ratio", "drive_frequency"], ["initial_angle", "initial_offset"]];

/**
 * Return options with some of them set, and what these replace left out.
 * @param {Record<string, string>} options
 * @param {Record<string, string>} changed
 * @returns {Record<string, string>}
 */
export function withOptions(options, changed) {
  const gone = ALTERNATIVES.flatMap((names) =>
    names.some((name) => name in changed) ? names : []);
  const kept = Object.entries(options).filter(([name]) => !gone.includes(name));
  return { ...Object.fromEntries(kept), ...changed };
}
