/** How an address describes a map: what it asks for, its axes, and the parts that cannot be read. */

import { splitQuantity } from "../model/units.js";
import { openState } from "../page/links.js";
import { FIRST } from "../page/state.js";
import { SCALES } from "./colours.js";

/** @typedef {import("../page/state.js").State} State */
/** @typedef {{scenario: string | null, stored: string | null}} MapSource */
/** @typedef {"x" | "y"} Which */
/** @typedef {Record<Which, {name: string}>} Axes of a map */

/** The shipped sweep that is shown where the address names nothing. */
const FIRST_MAP = "fig05_push";
/** Points along each axis of a map whose address names no number of them. */
export const USUAL_SIZE = 200;
// Such a map stops at every fourth of them, and goes on when somebody asks: all of them may take
// minutes. At every eighth on a phone or a tablet, which is some four times as slow.
const FIRST_STRIDE = { computer: 4, phone: 8 };
const LEAST_SIZE = 2;
/** Stands in the address for the parameters of the page. */
export const PAGE = "page";
const TAKEN = "map.at_";
const NUMBERS = ["xlow", "xhigh", "ylow", "yhigh", "duration", "transient", "low", "high"];
const SWITCHES = ["xlog", "ylog", "log"];
const TEXTS = ["x", "y", "observable", "ball", "contours", "scenario", "stored", "at", "off"];

/**
 * The source of a map's parameters: a stored map, a shipped sweep, or the page.
 * @param {any} registry
 * @param {State} state
 * @returns {MapSource}
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
 * Return the part of the state that names the shipped sweep on show: an address without a name stands for
 * one only as long as no option is changed.
 * @param {any} registry
 * @param {State} state
 * @returns {Partial<State>}
 */
export function withMapNamed(registry, state) {
  const { scenario } = sourceOf(registry, state);
  return scenario ? { extra: { ...state.extra, "map.scenario": scenario } } : {};
}

/**
 * The request in the address: see `question.js`, or a stored map.
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
  const log = (/** @type {Which} */ which) => {
    const text = get(`${which}log`);
    return text === null ? null : text === "1";
  };
  const { scenario, stored } = sourceOf(registry, state);
  const observable = get("observable");
  if (stored) {
    const select = Object.fromEntries(Object.entries(state.extra)
      .filter(([name]) => name.startsWith(TAKEN))
      .map(([name, v]) => [name.slice(TAKEN.length), Math.abs(Math.round(Number(v))) || 0]));
    return { stored, observable, select, xlog: log("x"), ylog: log("y") };
  }
  const axis = (/** @type {Which} */ which) =>
    ({ name: get(which), low: number(`${which}low`), high: number(`${which}high`), log: log(which) });
  const named = number("size");
  const size = named ?? USUAL_SIZE;
  const base = scenario ?? state.scenario ?? (state.options.system ? null : FIRST);
  return { scenario: base, options: state.options, x: axis("x"), y: axis("y"), observable,
    width: size, height: size, stride: named === null ? firstStride() : 1, duration: number("duration"), transient: number("transient") };
}

/** Return the stride at which a map stops whose address names no number of points. */
export function firstStride() {
  return FIRST_STRIDE[matchMedia("(pointer: coarse)").matches ? "phone" : "computer"];
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
 * @param {import("../page/state.js").Page} page
 * @param {Record<string, string>} options
 */
export function openInPlay(page, options) {
  const { extra } = page.store.state;
  openState(page, { extra, ...withMapNamed(page.registry, page.store.state), view: "toy", scenario: null, options });
}

/**
 * Return the parameter along an axis: that of the address, else the one on show or on its way.
 * @param {Record<string, string>} extra
 * @param {Axes | null} shown
 * @param {Which} which
 */
export function nameOf(extra, shown, which) {
  return extra[`map.${which}`] ?? shown?.[which].name ?? null;
}

/**
 * Return the entries of the address for an axis that is made logarithmic or linear; one that begins
 * at zero gets the usual start. A stored map has its points, and its spacing alone is kept.
 * @param {Record<string, string>} extra
 * @param {Axes | null} shown
 * @param {Which} which
 * @param {boolean} on
 */
export function spaced(extra, shown, which, on) {
  const log = { [`${which}log`]: on ? 1 : 0 };
  if (extra["map.stored"]) return log;
  const isUsual = on && !(Number(extra[`map.${which}low`]) > 0);
  return { [which]: nameOf(extra, shown, which), ...log, ...(isUsual && { [`${which}low`]: null }) };
}

/**
 * Return the entries of the address when another parameter is shown along an axis; that of the other
 * axis changes places with this one.
 * @param {Record<string, string>} extra
 * @param {Axes | null} shown
 * @param {Which} which
 * @param {string} name
 */
export function turned(extra, shown, which, name) {
  const other = which === "x" ? "y" : "x";
  const isSwapped = name === nameOf(extra, shown, other);
  /** @type {Record<string, string | null>} */
  const values = { at: null, [which]: name, ...(isSwapped && { [other]: nameOf(extra, shown, which) }) };
  for (const part of ["low", "high", "log"]) {
    const [own, others] = [which, other].map((each) => extra[`map.${each}${part}`] ?? null);
    values[which + part] = isSwapped ? others : null;
    if (isSwapped) values[other + part] = own;
  }
  return values;
}

/**
 * Return which keys of the address are unknown or hold no value of their kind.
 * @param {any} registry
 * @param {Record<string, string>} extra
 * @returns {string[]}
 */
export function misread(registry, extra) {
  const variables = Object.values(registry.observables).flatMap((each) => Object.keys(/** @type {any} */ (each).variables));
  const isNumber = (/** @type {string} */ part) => part.trim() !== "" && Number.isFinite(Number(part));
  const isStored = "map.stored" in extra;
  const isBad = (/** @type {string} */ name, /** @type {string} */ text) => {
    if (name === "size") return !(Number.isInteger(Number(text)) && Number(text) >= LEAST_SIZE);
    if (NUMBERS.includes(name)) return !isNumber(text);
    if (SWITCHES.includes(name)) return !["0", "1"].includes(text);
    if (name === "levels") return !text.split(",").every((part) => Number.isFinite(Number(splitQuantity(part)?.number ?? NaN)));
    if (name === "scale") return !SCALES.includes(text);
    if (name === "scenario") return text !== PAGE && !registry.scenarios[text]?.sweep;
    if (name === "observable" && !isStored) return !variables.includes(text);
    if (["x", "y"].includes(name) && !isStored) return !Object.hasOwn(registry.axes, text);
    return !TEXTS.includes(name) && !`map.${name}`.startsWith(TAKEN);
  };
  return Object.keys(extra).filter((key) => key.startsWith("map.")
    && isBad(key.slice("map.".length), extra[key])).sort();
}
