/** What is drawn over a map: curves of theory and of bifurcations, trials, contour lines. */

import { InputError } from "../model/rules.js";
import { readQuantity } from "../page/entry.js";
import { inLanguage, inPagesWords } from "../page/refusals.js";
import { loadText } from "../kernels/files.js";
import { sizeOf } from "./axes.js";
import { lookOf } from "./colours.js";
import { holdsCurves, parseCurves, placedCurve, pointNear } from "./overlay_curves.js";
import { linesOf, MOST_LEVELS, roundLevels } from "./levels.js";
import { OF_COLOURS } from "./overcontrols.js";
import { valueWithUnit } from "./texts.js";
import { liftOff, Placing, tongue } from "./theory.js";
import { parseTrials, placedTrials } from "./trials.js";
import { t } from "../strings.js";

/** @typedef {import("./contours.js").Contour} Contour */
/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Variable} Variable */
/** @typedef {{name: string, text: string}} TextFile its name, "" for what is no file of the user */
/** @typedef {{variable: number, text: string | null, levels: number[] | null, log: boolean}} OverlayQuestion place of
 *   the variable, levels and their text or null for round ones, whether these follow a logarithmic scale */
/** @typedef {{levels: number[], lines: number, tiny: number}} Drawn levels, their lines, and how many
 *   are left out because they are tiny */

/** The name of the address that lists the lines that are switched off. */
const OFF = "map.off";
// A click this near to a curve is one on it.
const NEAR = 8; // pixels of the page

/** What lies over the map of a view. */
export class Over {
  /** @param {import("./view.js").MapView} view */
  constructor(view) {
    this.view = view;
    /** @type {import("./overlay_curves.js").Line[]} of theory and of bifurcations over the map on show */
    this.lines = [];
    /** @type {TextFile | null} a trial table */
    this.trials = null;
    /** @type {TextFile[]} bifurcation curves */
    this.files = [];
    /** @type {Map<string, string>} texts of shipped curves, by their paths */
    this.shipped = new Map();
    /** @type {Grid | null} the map whose contour lines are drawn, and what was asked of it */
    this.drawnOn = null;
    this.drawn = "";
  }

  /** Take lines and trials over the map on show; they are drawn with its next picture. */
  place() {
    const { grid, chart, controls, page } = this.view;
    if (!grid) return;
    /** @type {string[]} */
    const notes = [];
    const placing = this.attempt(() => new Placing(grid), notes);
    const theory = placing ? [tongue, liftOff].flatMap((line) => this.attempt(() => line(placing), notes) ?? []) : [];
    this.lines = [...theory, ...this.curves(grid, notes)];
    controls.over.showLines(this.lines, [...new Set(notes)], () => this.off());
    /** @type {string[]} */
    const refused = [];
    const { trials } = this;
    const placed = trials && placing ? this.attempt(() =>
      placedTrials(parseTrials(page.registry, trials.text), placing), refused, trials.name) : null;
    chart.trials = placed?.trials ?? null;
    controls.over.showTrials(placed, refused);
  }

  /**
   * Take what files hold: bifurcation curves, and of trials the last table.
   * @param {TextFile[]} files
   */
  take(files) {
    this.files = files.filter(({ text }) => holdsCurves(text));
    this.trials = files.findLast(({ text }) => !holdsCurves(text)) ?? null;
    this.place();
    this.view.repaint();
  }

  /**
   * Return the curves of the map's scenario, of an analysis and of files.
   * @param {Grid} grid
   * @param {string[]} notes
   */
  curves(grid, notes) {
    const { page, request } = this.view;
    const path = page.registry.scenarios[request.scenario]?.curves;
    if (path && !this.shipped.has(path)) void this.load(path);
    /** @type {Record<string, number>} */
    const counts = {};
    const own = [this.shipped.get(path) ?? "", ...page.curves ?? []].map((text) => ({ name: "", text }));
    const read = [...own, ...this.files].flatMap(({ name, text }) =>
      (this.attempt(() => parseCurves(text), notes, name) ?? []).map((curve) => ({ name, curve })));
    return read.flatMap(({ name: file, curve }) => {
      const placed = this.attempt(() => placedCurve(page.registry, curve, grid), notes, file);
      if (!placed) return [];
      const count = counts[curve.kind] = (counts[curve.kind] ?? 0) + 1;
      return [{ ...placed, name: count > 1 ? `${curve.kind}_${count}` : curve.kind,
        label: count > 1 ? `${placed.label} ${count}` : placed.label }];
    });
  }

  /** @param {string} path of curves that come with the map's scenario */
  async load(path) {
    this.shipped.set(path, "");
    try {
      this.shipped.set(path, await loadText(path));
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      // Without a network there are none; the next map asks again.
      this.shipped.delete(path);
      return;
    }
    this.place();
    this.view.repaint();
  }

  /** Return the names of the lines that are switched off. */
  off() {
    return (this.view.page.store.state.extra[OFF] ?? "").split(",").filter(Boolean);
  }

  /** Return the lines that are switched on. */
  shown() {
    const off = this.off();
    return this.lines.filter(({ name }) => !off.includes(name));
  }

  /** Return the curves of bifurcations that are switched on. */
  shownCurves() {
    return /** @type {import("./overlay_curves.js").PlacedCurve[]} */ (this.shown().filter((line) => "kind" in line));
  }

  /**
   * Return the point of a bifurcation curve at a place of the map, null if no curve is there.
   * @param {[number, number]} at
   * @param {number} [most] how far it may be, in pixels of the page
   */
  pointAt(at, most = NEAR) {
    return pointNear(this.view.chart, this.shownCurves(), at, most * (window.devicePixelRatio || 1));
  }

  /**
   * The result of a function; if it refuses its input, null, with a sentence among the notes.
   * @template T
   * @param {() => T} make
   * @param {string[]} notes
   * @param {string} [file] that holds the input
   */
  attempt(make, notes, file) {
    try {
      return make();
    } catch (error) {
      if (!(error instanceof InputError)) throw error;
      notes.push(file ? inLanguage(new InputError(error.rule, { ...error.about, where: file }))
        : inPagesWords(this.view.page.registry, error)[0]);
      return null;
    }
  }

  /**
   * Take the contour lines that the address names once the map grows no more; those of another map
   * go.
   */
  contours() {
    const { grid, chart, controls } = this.view;
    const question = this.question();
    const isLater = this.view.growing();
    const text = JSON.stringify([question, isLater, grid?.done]);
    if (text === this.drawn && grid === this.drawnOn) return;
    [this.drawn, this.drawnOn] = [text, grid];
    /** @type {string[]} */
    const notes = [];
    const drawn = question && grid && !isLater ? this.attempt(() => contoursOf(grid, question), notes) : null;
    chart.contours = drawn?.contours ?? [];
    controls.over.showContours(question && grid ? grid.variables[question.variable] : null, question?.text ?? null,
      drawn, isLater, notes);
  }

  /**
   * The variable and levels of the contour lines, null for none.
   * @returns {OverlayQuestion | null}
   */
  question() {
    const { grid, page } = this.view;
    const { extra } = page.store.state;
    const variable = grid && contourVariable(grid, extra);
    if (!grid || !variable) return null;
    const log = extra["map.contours"] === OF_COLOURS && lookOf(grid, extra).log;
    const text = extra["map.levels"] ?? null;
    return { variable: grid.variables.indexOf(variable), log, text,
      levels: text?.split(",").map((part) => readQuantity(page.registry, part, variable.unit).value) ?? null };
  }
}

/**
 * Return the contour lines of a map.
 * @param {Grid} grid
 * @param {OverlayQuestion} question
 * @returns {Drawn & {contours: Contour[]}}
 */
function contoursOf(grid, { variable, levels, log }) {
  const about = grid.variables[variable];
  const all = levels ? checkedLevels(levels)
    : roundLevels(...grid.range(variable, log), sizeOf(about), log)
      .slice(0, MOST_LEVELS);
  const { lines, tiny } = linesOf(grid, variable, all);
  return { levels: all, lines: lines.length, tiny,
    contours: lines.map((line) => ({ ...line, text: valueWithUnit(about, line.level) })) };
}

/**
 * Return levels that the address names in order, each once.
 * @param {number[]} levels
 */
function checkedLevels(levels) {
  if (levels.length > MOST_LEVELS)
    throw new InputError(t("refuseLevels", { most: MOST_LEVELS, count: levels.length }));
  const bad = levels.find((level) => !Number.isFinite(level));
  if (bad !== undefined)
    throw new InputError(t("refuseLevel"), { value: bad });
  return [...new Set(levels)].sort((a, b) => a - b);
}

/**
 * Return the variable that contour lines are asked of, null for none.
 * @param {Grid} grid
 * @param {Record<string, string>} extra
 * @returns {Variable | null}
 */
export function contourVariable(grid, extra) {
  const name = extra["map.contours"];
  if (!name) return null;
  const { variable } = lookOf(grid, extra);
  const at = name === OF_COLOURS ? variable
    : [grid.variable(name, extra["map.ball"] ?? null), grid.variable(name)].find((k) => k >= 0);
  const found = at === undefined ? null : grid.variables[at];
  return found && !found.classes.length ? found : null;
}
