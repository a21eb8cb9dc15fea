/** What a map says in words: places, values, colours. */

import { el } from "../page/dom.js";
import { besideUnit, localShort, plainSymbol, shownUnit } from "../page/unit_text.js";
import { t, tr } from "../strings.js";
import { sizeOf } from "./axes.js";
import { CLASSES, SIGNS } from "./marks.js";
import { classesOf, wordOf } from "./class_words.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Variable} Variable */

// Lines do not break here.
const GAP = "\u00a0";

/**
 * Return a value with the unit in which it is shown.
 * @param {{units: {name: string, size: number}[]}} about
 * @param {number} value in SI units
 */
export function valueWithUnit(about, value) {
  return besideUnit(localShort(value / sizeOf(about), 4), shownUnit(about.units[0]?.name ?? ""), GAP);
}

/**
 * Return a parameter and its value.
 * @param {Pick<import("./grid.js").Axis, "symbol" | "label" | "units">} axis
 * @param {number} value in SI units
 */
export function withName(axis, value) {
  return `${plainSymbol(axis.symbol) || axis.label}${GAP}=${GAP}${valueWithUnit(axis, value)}`;
}

/**
 * A cell's axis values and its value, or why there is none, in words.
 * @param {Grid} grid
 * @param {number} cell
 * @param {number} k place of the variable
 */
export function cellText(grid, cell, k) {
  const column = cell % grid.width;
  const line = (cell - column) / grid.width;
  const variable = grid.variables[k];
  const value = grid.values[k][cell];
  const lack = grid.lack(cell, k);
  let words = valueWithUnit(variable, value);
  if (lack) words = t(lack, { status: grid.about.statuses[grid.status[cell]] });
  else if (variable.words) words = wordOf(variable, value);
  else if (variable.classes.length) words = variable.classes[Math.round(value)]?.[0] ?? "";
  const coarse = grid.isKnown(cell) || lack ? "" : ` ${t("mapCoarse")}`;
  return [withName(grid.x, grid.x.values[column]), withName(grid.y, grid.y.values[line]),
    `${variable.label}: ${words}${coarse}`].join(" · ");
}

/**
 * Return what a part of a curve is.
 * @param {string} label of the kind
 * @param {boolean} isEdge whether stable motions end there
 */
export function kindText(label, isEdge) {
  return isEdge ? label : t("mapUnstable", { label });
}

/**
 * Return the entries that explain colours of classes, cells without an answer, zeros, lines, trials and contour lines.
 * @param {Grid} grid
 * @param {import("./chart.js").Look} look
 * @param {{lines: import("./overlay_curves.js").Line[], trials: boolean, contours: Variable | null, registry: Pick<import("../model/registry.js").Registry, "curves">}} over
 */
export function legend(grid, { variable: k, log }, { lines, trials, contours, registry }) {
  const entry = (/** @type {string} */ text, /** @type {string} */ paint) => {
    const key = el("span", { class: "swatch" });
    key.style.background = paint;
    return el("li", {}, key, text);
  };
  const bad = grid.withoutAnswer();
  const zeros = log ? grid.values[k].filter((value) => value <= 0).length : 0;
  return [
    ...classesOf(grid, k).classes.map(([text, paint]) => entry(text, paint)),
    ...(bad ? [entry(t("mapNoAnswer", { count: bad }), "var(--faint)")] : []),
    ...(zeros ? [entry(t("mapZero", { count: zeros }), "var(--paper)")] : []),
    ...lines.flatMap(({ label, colour, edges }) => [true, false].filter((isEdge) => edges.includes(isEdge)).map((isEdge) => {
      const key = el("span", { class: colour ? "curve-key bifurcation" : "curve-key" });
      key.style.borderTopColor = colour;
      key.style.borderTopStyle = isEdge ? "solid" : "dashed";
      return el("li", {}, key, colour ? kindText(label, isEdge) : label);
    })),
    ...[...new Set(lines.flatMap((curve) => curve.marks.map(({ kind }) => kind)))].map((kind) => el("li", {},
      el("span", { class: "trial", "aria-hidden": "true" }, SIGNS[registry.curves.marks[kind]?.mark] ?? SIGNS.o),
      tr(registry.curves.marks[kind]?.label ?? kind))),
    ...(contours ? [el("li", {}, el("span", { class: "curve-key contour" }),
      t("mapContoursOf", { what: contours.label }))] : []),
    ...(trials ? CLASSES : []).map((name) => el("li", {},
      el("span", { class: `trial ${name}`, "aria-hidden": "true" }, SIGNS[name]), t(`trial_${name}`))),
  ];
}

/**
 * Return the summary of a map that has come to its end: its points, those that are new or missing,
 * and how many a finer one has.
 * @param {Grid} grid
 * @param {import("./pool.js").Progress} [progress] of a map that was computed
 */
export function doneText(grid, { points, seconds, rate } = { points: 0, seconds: 0, rate: 0, share: 1 }) {
  const whole = grid.width * grid.height;
  const all = grid.done;
  const missing = grid.about.stored?.missing;
  if (missing) return t("mapKnownPart", { points: all, missing });
  const text = points ? t(points < all ? "mapDonePart" : "mapDone", { all, points, seconds: localShort(seconds, 2),
    rate: Math.round(rate) }) : t("mapKnown", { points: all });
  return all === whole ? text : `${text}. ${t("mapWhole", { whole })}`;
}
