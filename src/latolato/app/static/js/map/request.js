/** What the Map view asks for, from the address of the page. */

import { FIRST } from "../shared/state.js";

/** @typedef {import("../shared/state.js").State} State */
/** @typedef {{scenario: string | null, stored: string | null}} Source */

/** The shipped sweep that is shown where the address names nothing. */
export const FIRST_MAP = "fig05_push";
export const USUAL_SIZE = 200;
/** Stands in the address for the parameters of the page. */
export const PAGE = "page";
const TAKEN = "map.at_";

/**
 * Return where the parameters of a map come from: a stored map, a shipped sweep, or the page.
 * @param {any} registry
 * @param {State} state
 * @returns {Source}
 */
export function sourceOf(registry, state) {
  const stored = state.extra["map.stored"] ?? null;
  if (stored) return { scenario: null, stored };
  const named = state.extra["map.scenario"] ?? state.scenario;
  if (named === PAGE) return { scenario: null, stored: null };
  if (named && registry.scenarios[named]?.sweep) return { scenario: named, stored: null };
  const untouched = !state.scenario && !Object.keys(state.options).length;
  return { scenario: untouched ? FIRST_MAP : null, stored: null };
}

/**
 * Return what the address asks for: see `question.js`, or a stored map.
 * @param {any} registry
 * @param {State} state
 * @returns {Record<string, any>}
 */
export function requestOf(registry, state) {
  const get = (/** @type {string} */ name) => state.extra[`map.${name}`] ?? null;
  const number = (/** @type {string} */ name) => {
    const value = get(name);
    return value === null || !Number.isFinite(Number(value)) ? null : Number(value);
  };
  const { scenario, stored } = sourceOf(registry, state);
  const observable = get("observable");
  if (stored) {
    const select = Object.fromEntries(Object.entries(state.extra)
      .filter(([name]) => name.startsWith(TAKEN))
      .map(([name, v]) => [name.slice(TAKEN.length), Math.abs(Math.round(Number(v))) || 0]));
    const log = (/** @type {"x" | "y"} */ which) => ({ 0: false, 1: true })[
      /** @type {0 | 1} */ (number(`${which}log`))] ?? null;
    return { stored, observable, select, xlog: log("x"), ylog: log("y") };
  }
  const axis = (/** @type {"x" | "y"} */ which) => {
    const log = get(`${which}log`);
    const given = Object.entries({ name: get(which), low: number(`${which}low`),
      high: number(`${which}high`), log: log === null ? null : log === "1" });
    const said = given.filter(([, value]) => value !== null);
    return said.length ? Object.fromEntries(said) : null;
  };
  const size = Math.max(2, Math.round(number("size") ?? USUAL_SIZE));
  const base = scenario ?? state.scenario ?? (state.options.system ? null : FIRST);
  return { scenario: base, options: state.options, x: axis("x"), y: axis("y"), observable,
    width: size, height: size, duration: number("duration"), transient: number("transient") };
}

/**
 * Return a text that is the same for requests that differ in the observable only.
 * @param {Record<string, any>} request
 */
export function sameBut(request) {
  return JSON.stringify({ ...request, observable: null });
}

/**
 * Open a run of a map in Play; the way back leads to the same map.
 * @param {import("../shared/state.js").Page} page
 * @param {Record<string, string>} options
 */
export function openInPlay({ registry, store }, options) {
  const { scenario } = sourceOf(registry, store.state);
  const extra = { ...store.state.extra };
  if (scenario) extra["map.scenario"] = scenario;
  store.set({ view: "play", scenario: null, options, extra }, "view");
}
