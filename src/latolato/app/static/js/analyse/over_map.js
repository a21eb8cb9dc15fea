/** From a bifurcation curve to a map of the same system with the curve over it. */

import { openState } from "../page/links.js";

// What goes to the right on maps.
const FREQUENCY = /^(drive_frequency|frequency_ratio)$/;

/**
 * Open a map of the page's system over both parameters of a curve, and the curve over it.
 * @param {import("../page/state.js").Page} page
 * @param {string} text of the curve's CSV, which the page keeps until it is loaded again
 */
export function openOverMap(page, text) {
  const label = (/** @type {string} */ name) => new RegExp(`^# ${name}: (.*)$`, "m").exec(text)?.[1] ?? "";
  const names = label("parameters").match(/\w+/g) ?? ["", ""];
  const [low, high] = ["low", "high"].map((name) => label(name).match(/[^\s[\]]+/g)?.map(Number) ?? []);
  page.curves = [...(page.curves ?? []).filter((each) => each !== text), text];
  // Else the first parameter is upwards, as in the curve's own picture.
  const [x, y] = FREQUENCY.test(names[0]) ? [0, 1] : [1, 0];
  const { scenario, options, extra } = page.store.state;
  const others = Object.entries(extra).filter(([name]) => !name.startsWith("map."));
  const axis = (/** @type {string} */ which, /** @type {number} */ k) => ({ [`map.${which}`]: names[k],
    [`map.${which}low`]: String(low[k]), [`map.${which}high`]: String(high[k]) });
  openState(page, { view: "map", scenario, options,
    extra: { ...Object.fromEntries(others), "map.scenario": "page", ...axis("x", x), ...axis("y", y) } });
}
