/** Choices of a person, kept in the browser from one visit to the next where it keeps anything. */

import { t } from "../strings.js";
import { notify } from "./dom.js";

/** What the browser did not keep, until the page is left. @type {Map<string, string>} */
const unkept = new Map();
let isSaid = false;

/**
 * Return a text that was kept, null without one.
 * @param {string} key
 */
export function recall(key) {
  try {
    return unkept.get(key) ?? localStorage.getItem(key);
  } catch {
    return null; // the browser keeps nothing for this page
  }
}

/**
 * Keep a text; where the browser does not, it holds until the page is left, which is said once.
 * @param {string} key
 * @param {string} text
 */
export function keep(key, text) {
  try {
    localStorage.setItem(key, text);
    unkept.delete(key);
  } catch {
    unkept.set(key, text);
    if (!isSaid) notify(t("unkept"));
    isSaid = true;
  }
}
