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

/** @template T */
class Preferences {
  /** @param {string} key in the browser's storage */
  constructor(key) {
    this.key = key;
    /** @type {Record<string, T> | null} */
    this.known = null;
  }

  /** The choices made now or the last time. */
  get all() {
    if (this.known) return this.known;
    try {
      this.known = { ...JSON.parse(recall(this.key) ?? "{}") };
    } catch {
      this.known = {}; // spoiled by somebody
    }
    return /** @type {Record<string, T>} */ (this.known);
  }

  /**
   * Keep a choice.
   * @param {string} name
   * @param {T} value
   */
  keep(name, value) {
    this.all[name] = value;
    keep(this.key, JSON.stringify(this.all));
  }
}

/** The unit that was chosen last for each option. @type {Preferences<string>} */
export const unitPreferences = new Preferences("latolato.scenario.units");
/** Which descriptions and sounds are on. @type {Preferences<boolean>} */
export const accessibilityPreferences = new Preferences("latolato.senses");
