/** Links that lead to another view with other parameters. */

import { el } from "./dom.js";
import { format } from "./state.js";

/** @typedef {import("./state.js").Page} Page */
/** @typedef {{view: string, scenario: string | null, options: Record<string, string>,
 *   extra?: Record<string, string>}} Target */

/**
 * Return a link whose plain click does something in this page; it can be opened in a new tab too.
 * @param {string} address
 * @param {() => void} act
 * @param {Record<string, any>} attributes
 * @param {...(Node | string)} children
 * @returns {HTMLAnchorElement}
 */
export function actingLink(address, act, attributes, ...children) {
  return el("a", { href: address, ...attributes, on: { click: (/** @type {MouseEvent} */ event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    act();
  } } }, ...children);
}

/**
 * Return a link that opens a state of the page.
 * @param {Page} page
 * @param {Target} target
 * @param {string} text
 * @param {string} [title]
 * @returns {HTMLAnchorElement}
 */
export function openLink(page, target, text, title) {
  return actingLink(addressOf(page, target), () => openState(page, target), { class: "open", title }, text);
}

/**
 * @param {Page} page
 * @param {Target} target
 */
function addressOf({ store: { state: { lang } } }, target) {
  return format({ extra: {}, lang, ...target });
}

/**
 * Return nothing; the page shows another view, with these parameters.
 * @param {Page} page
 * @param {Target} target
 */
export function openState(page, target) {
  page.store.set(target, "view");
  window.scrollTo(0, 0);
}
