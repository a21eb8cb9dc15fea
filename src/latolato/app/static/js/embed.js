/** A view in a frame of another page: the messages that it sends to that page and takes from it. */

import { format } from "./shared/state.js";

/** @typedef {import("./shared/state.js").Store} Store */

const TYPE = "latolato";
// Longer texts are no parameters.
const LONGEST = 1000;

/**
 * Return the scenario and the options that a message asks for, null for other messages.
 * @param {any} registry
 * @param {any} data `{type: "latolato", scenario, options}`; scenario may be missing or null
 * @returns {{scenario: string | null, options: Record<string, string>} | null}
 */
export function wishOf(registry, data) {
  if (!isPlain(data) || data.type !== TYPE || !isPlain(data.options)) return null;
  if (Object.keys(data).some((name) => !["type", "scenario", "options"].includes(name))) return null;
  const scenario = data.scenario ?? null;
  if (scenario !== null && (typeof scenario !== "string" || !Object.hasOwn(registry.scenarios, scenario)))
    return null;
  const entries = Object.entries(data.options);
  const isKnown = entries.every(([name, value]) => Object.hasOwn(registry.options, name)
    && (Number.isFinite(value) || (typeof value === "string" && value.length <= LONGEST)));
  return isKnown ? { scenario, options: Object.fromEntries(entries.map(([name, value]) =>
    [name, String(value)])) } : null;
}

/** @param {any} value */
function isPlain(value) {
  return typeof value === "object" && value !== null && Object.getPrototypeOf(value) === Object.prototype;
}

/**
 * Tell the page around this one the height and the address of the view whenever they change, and
 * show what it asks for. Messages of other windows are ignored, and so is what `wishOf` does not know.
 * @param {any} registry
 * @param {Store} store
 */
export function talkToParent(registry, store) {
  if (window.parent === window) return;
  let last = "";
  const send = () => {
    const height = Math.ceil(document.body.getBoundingClientRect().height);
    const address = format(store.state);
    if (last === `${height} ${address}`) return;
    last = `${height} ${address}`;
    // Whoever embeds the page may know both: it holds nothing but the parameters on show.
    window.parent.postMessage({ type: TYPE, height, address }, "*");
  };
  new ResizeObserver(send).observe(document.body);
  store.subscribe(send);
  window.addEventListener("message", ({ source, data }) => {
    const wish = source === window.parent ? wishOf(registry, data) : null;
    if (wish) store.set(wish, "options");
  });
}
