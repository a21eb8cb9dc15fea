/** What an address says of a map that cannot be read. */

import { el } from "../shared/dom.js";
import { t } from "../strings.js";
import { SCALES } from "./colours.js";

/** @typedef {import("../shared/state.js").Store} Store */

const NUMBERS = ["xlow", "xhigh", "ylow", "yhigh", "size", "duration", "transient", "low", "high"];
const SWITCHES = ["xlog", "ylog", "log", "tongue", "lift"];

/**
 * Return which keys of the address hold no value of their kind.
 * @param {Record<string, string>} extra
 */
export function misread(extra) {
  const bad = (/** @type {string} */ name, /** @type {string} */ text) => {
    const isNumber = (/** @type {string} */ part) => part.trim() !== ""
      && Number.isFinite(Number(part));
    if (NUMBERS.includes(name)) return !isNumber(text);
    if (SWITCHES.includes(name)) return !["0", "1"].includes(text);
    if (name === "levels") return !text.split(",").every(isNumber);
    return name === "scale" && !SCALES.includes(text);
  };
  return Object.keys(extra).filter((key) => key.startsWith("map.")
    && bad(key.slice("map.".length), extra[key])).sort();
}

/** The line that says which parts of an address were left out. */
export class Misread {
  constructor() {
    this.root = el("p", { class: "error", role: "alert", hidden: true });
    this.left = "";
  }

  /**
   * Take what cannot be read out of the address and say so, until something else is chosen.
   * @param {Store} store
   */
  heed(store) {
    const { extra } = store.state;
    const bad = misread(extra);
    const kept = Object.fromEntries(Object.entries(extra).filter(([key]) => !bad.includes(key)));
    const { "map.at": _, ...left } = kept;
    const text = JSON.stringify(left);
    if (!bad.length) {
      if (text !== this.left) this.root.hidden = true;
      return;
    }
    this.left = text;
    this.root.hidden = false;
    const parts = bad.map((key) => `${key}=${extra[key]}`).join(", ");
    this.root.textContent = t("mapMisread", { parts });
    store.set({ extra: kept }, "extra");
  }
}
