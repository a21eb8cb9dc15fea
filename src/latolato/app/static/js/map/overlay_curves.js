/** Bifurcation curves over a map: from the CSV of `latolato analyse` to places and orbits on it. */

import { brokenRule, general, InputError } from "../model/rules.js";
import { t, tr } from "../strings.js";
import { optionsAt } from "./about.js";
import { kindText, withName, valueWithUnit } from "./texts.js";
import { Placing } from "./theory.js";
import { columnsOf, LINE_END } from "./trials.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("../model/registry.js").Registry} Registry */
/**
 * A curve, by points: the values of both parameters [SI], the motion at time zero, a number for each
 * ball, its largest angle [rad] and its word, and whether a stable motion ends there. `births` are
 * those of `is_supercritical` in `latolato.analysis.bifurcation_curve`, none for kinds without them.
 * `special` are the points of codimension two.
 * @typedef {{text: string, kind: string, parameters: [string, string], labels: Record<string, string>,
 *   values: [number[], number[]], angles: number[][],
 *   velocities: number[][], largest: number[], words: string[], edges: boolean[], births: number[],
 *   special: {kind: string, values: number[]}[]}} OverlayCurve
 *
 * A line over a map, and a curve of bifurcations there: `name` tells it from the others, `xs` and `ys` are
 * along the map's axes, `edges` says which points are on solid parts. Theory has no colour of its own.
 * @typedef {{name: string, label: string, colour: string, xs: number[], ys: number[], edges: boolean[],
 *   marks: {x: number, y: number, kind: string, mark: string}[]}} Line
 * @typedef {OverlayCurve & Line} PlacedCurve
 *
 * A point of a curve.
 * @typedef {{curve: PlacedCurve, i: number}} CurvePoint
 */

const LABEL = /^# (\w+): (.*)$/;
const TABLE = /^# over (.+)$/;
const IS_CURVE = /^# analysis: bifurcation_curve\s*$/m;
// The phase of the drive turns motions, and bifurcations with them.
const TURNS = "drive_phase";
// Numbers closer than this differ by rounding only.
const SAME = 1e-9;
// An orbit is shown for so many of its periods.
const PERIODS = 20;
const RUN = ["contact", "tolerance", "rest_speed"];

/**
 * Return whether a text holds bifurcation curves, and not trials.
 * @param {string} text
 */
export function holdsCurves(text) {
  return IS_CURVE.test(text.replaceAll("\r\n", "\n"));
}

/**
 * Return the curves in a text; `latolato.app.map.curves.read_curves` does the same.
 * @param {string} text
 * @returns {OverlayCurve[]}
 * @throws {InputError} if it holds something else
 */
export function parseCurves(text) {
  /** @type {{text: string[], labels: Record<string, string>, tables: Map<string, string[]>}[]} */
  const parts = [];
  /** @type {string[] | null} */
  let lines = null;
  for (const line of text.replace(/^\ufeff/, "").split(LINE_END)) {
    const [, table] = TABLE.exec(line) ?? [];
    const [, name, value] = LABEL.exec(line) ?? [];
    if (table && parts.length) parts[parts.length - 1].tables.set(table, lines = []);
    else if (name) {
      // Labels stand above the tables of a curve.
      if (!parts.length || lines) parts.push({ text: [], labels: {}, tables: new Map() });
      lines = null;
      parts[parts.length - 1].labels[name] = value;
    } else if (line) lines?.push(line);
    parts.at(-1)?.text.push(line);
  }
  return parts.map(({ text: own, labels, tables }) => ({ text: own.join("\n"), ...curveOf(labels, tables) }));
}

/**
 * @param {Record<string, string>} labels
 * @param {Map<string, string[]>} tables lines by their dimensions
 * @returns {Omit<OverlayCurve, "text">}
 */
function curveOf(labels, tables) {
  /** @type {Map<string, string[]>} */
  const columns = new Map();
  for (const lines of tables.values())
    for (const [head, cells] of columnsOf(lines)) columns.set(head.split(" [")[0], cells);
  const texts = (/** @type {string} */ name) => {
    const cells = columns.get(name);
    if (!cells) throw new InputError(t("refuseCurve", { name }));
    return cells;
  };
  const numbers = (/** @type {string} */ name) => texts(name).map(Number);
  const [one, other] = Array.from((labels.parameters ?? "").matchAll(/'(\w+)'/g), ([, name]) => name);
  const values = /** @type {[number[], number[]]} */ ([numbers(one), numbers(other)]);
  const special = [numbers(`special_${one}`), numbers(`special_${other}`)];
  const balls = numbers("initial_angle").length / (values[0].length || 1);
  const perBall = (/** @type {number[]} */ all) => values[0].map((_, i) => all.slice(balls * i, balls * (i + 1)));
  return { kind: labels.bifurcation, parameters: [one, other], labels, values,
    angles: perBall(numbers("initial_angle")), velocities: perBall(numbers("initial_angular_velocity")),
    largest: numbers("largest_angle"), words: texts("word"), edges: numbers("is_edge").map(Boolean),
    births: columns.get("is_supercritical")?.map(Number) ?? [],
    special: texts("special_kind").map((kind, i) => ({ kind, values: special.map((each) => each[i]) })) };
}

/**
 * Return a curve over a map.
 * @param {Registry} registry
 * @param {OverlayCurve} curve
 * @param {Grid} grid
 * @returns {Omit<PlacedCurve, "name">}
 * @throws {InputError} if it is of another system, or over other parameters
 */
export function placedCurve({ curves, ...registry }, curve, grid) {
  checkSame(registry, curve, grid);
  const place = placing(curve, grid);
  const { kind, values, special } = curve;
  const points = values[0].map((value, i) => place([value, values[1][i]]));
  if (!Object.hasOwn(curves.kinds, kind)) throw new InputError(t("refuseCurve", { name: "bifurcation" }));
  const { label, colour } = curves.kinds[kind];
  const marks = special.map((each) => {
    const [x, y] = place(each.values);
    return { x, y, kind: each.kind, mark: curves.marks[each.kind]?.mark ?? "o" };
  });
  return { ...curve, label: tr(label), colour, marks, xs: points.map(([x]) => x), ys: points.map(([, y]) => y) };
}

/**
 * Return what turns both values of a curve into those of a map's axes.
 * @param {OverlayCurve} curve
 * @param {Grid} grid
 * @returns {(values: number[]) => [number, number]}
 */
function placing({ parameters, labels }, grid) {
  const at = [grid.x, grid.y].map(({ name }) => parameters.indexOf(name));
  if (!at.includes(-1)) return (values) => [values[at[0]], values[at[1]]];
  // Both are of amplitude and frequency, in other units.
  const [x, y] = parameters;
  const numbers = Object.fromEntries(Object.entries(labels).map(([name, text]) => [name, Number(text)]));
  const own = new Placing(/** @type {any} */ ({ x: { name: x, edges: [] }, y: { name: y, edges: [] },
    about: { parameters: numbers, laws: labels } }));
  const over = new Placing(grid);
  return ([one, other]) => over.place(own.plain({ [x]: one, [y]: other }));
}

/**
 * Throw if a curve is of another system than a map; `_check_same` in `latolato.figures.overlays` does the same.
 * @param {Pick<Registry, "systems" | "drives" | "options" | "axes">} registry
 * @param {OverlayCurve} curve
 * @param {Grid} grid
 */
function checkSame({ systems, drives, options, axes }, { labels, parameters }, { about: { laws }, x, y }) {
  const varied = [x.name, y.name, ...parameters];
  const skipped = new Set([...varied, ...varied.map((name) => axes[name]?.sets), TURNS]);
  const { options: inSystem = [], contacts = false } = systems[labels.system] ?? {};
  // Without anything to hit, the law of contact says nothing.
  const own = [...contacts ? ["contact"] : [], ...inSystem, ...drives[labels.drive]?.options ?? []];
  for (const name of ["system", "drive", ...own.sort()]) {
    if (skipped.has(name)) continue;
    const usual = name === "contact" ? "none" : options[name]?.default;
    const [here, there] = [laws[name] ?? usual, labels[name] ?? usual];
    const both = [here, there].map(Number);
    const isClose = Math.abs(both[0] - both[1]) <= SAME * Math.max(...both.map(Math.abs));
    if (String(here) === String(there) || isClose) continue;
    throw brokenRule("other_system", {}, { name, here: said(here), there: said(there) });
  }
}

/** @param {any} value a number, or the text of one or of a name */
function said(value) {
  return Number.isFinite(Number(value)) ? general(Number(value), 9) : String(value);
}

/**
 * Return the options of the orbit at a point of a curve, in SI units.
 * @param {Registry} registry
 * @param {CurvePoint} point
 * @returns {Record<string, any>}
 */
export function orbitOptions(registry, { curve, i }) {
  const { labels, parameters, values } = curve;
  const { systems, drives } = registry;
  const own = [...systems[labels.system].options, ...drives[labels.drive].options, ...RUN]
    .filter((name) => name in labels);
  const base = { system: labels.system, drive: labels.drive,
    ...Object.fromEntries(own.map((name) =>
      [name, Number.isNaN(Number(labels[name])) ? labels[name] : Number(labels[name])])) };
  const at = optionsAt(registry, base, Object.fromEntries(parameters.map((name, k) => [name, values[k][i]])));
  const one = (/** @type {number[]} */ each) => (each.length > 1 ? each : each[0]);
  return { ...at, initial_angle: one(curve.angles[i]), initial_angular_velocity: one(curve.velocities[i]),
    duration: PERIODS * Number(labels.period) * 2 * Math.PI / at.drive_frequency };
}

/**
 * Return a point of a curve in words: what happens there, where that is, and the motion's word and angle.
 * @param {Registry} registry
 * @param {CurvePoint} point
 */
export function curveText({ axes, observables }, { curve, i }) {
  const [word, angle] = ["contact_word", "largest_angle"].map((name) => observables[name].variables[name]);
  const edge = curve.edges[i] ? { 1: t("mapSoftEdge"), 0: t("mapSteepEdge") }[curve.births[i]] : undefined;
  return [kindText(curve.label, curve.edges[i]), ...(edge ? [edge] : []),
    ...[1, 0].map((k) => withName(/** @type {any} */ (axes[curve.parameters[k]]), curve.values[k][i])),
    `${word.label}: ${tr(curve.words[i])}`, `${angle.label}: ${valueWithUnit(angle, curve.largest[i])}`].join(" · ");
}

/**
 * Return the point of the curves that is nearest to a place of the canvas, null if no curve is near.
 * @param {import("./chart.js").MapChart} chart
 * @param {PlacedCurve[]} curves
 * @param {[number, number]} at values at the place
 * @param {number} most how far a curve may be, in pixels of the canvas
 * @returns {CurvePoint | null}
 */
export function pointNear(chart, curves, at, most) {
  const [x, y] = chart.place(...at);
  /** @type {{distance: number, point: CurvePoint | null}} */
  let best = { distance: most, point: null };
  for (const curve of curves) {
    const places = curve.xs.map((value, i) => chart.place(value, curve.ys[i]));
    const distances = places.map(([a, b]) => Math.hypot(a - x, b - y));
    const along = places.map((place, i) => distanceTo([x, y], place, places[i + 1] ?? place));
    const distance = Math.min(...along);
    if (!(distance <= best.distance)) continue;
    // Only orbits at computed points close; those beyond the picture are not pointed at.
    const inside = [...curve.xs.keys()].filter((i) => chart.cell(curve.xs[i], curve.ys[i]) >= 0);
    if (!inside.length) continue;
    best = { distance, point: { curve, i: inside.reduce((a, b) => (distances[b] < distances[a] ? b : a)) } };
  }
  return best.point;
}

/**
 * Return how far a place is from a straight line between two others; not a number beyond the picture.
 * @param {number[]} place
 * @param {number[]} from
 * @param {number[]} to
 */
function distanceTo([x, y], [x0, y0], [x1, y1]) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const share = Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(x0 + share * dx - x, y0 + share * dy - y);
}
