/** What is drawn over a map: curves of theory, trials, contour lines. */

import { InputError } from "../model/rules.js";
import { inPagesWords } from "../page/refusals.js";
import { lookOf } from "./colours.js";
import { linesOf, MOST_LEVELS, roundLevels } from "./levels.js";
import { OF_COLOURS } from "./overcontrols.js";
import { withUnit } from "./texts.js";
import { liftOff, Placing, tongue } from "./theory.js";
import { parseTrials, placedTrials } from "./trials.js";
import { t } from "../strings.js";

/** @typedef {import("./contours.js").Contour} Contour */
/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Variable} Variable */
/** @typedef {import("./theory.js").NamedLine} NamedLine */
/** @typedef {{variable: number, levels: number[] | null, log: boolean}} OverlayQuestion place of the
 *   variable, levels or null for round ones, whether these follow a logarithmic scale */
/** @typedef {{levels: number[], lines: number, tiny: number}} Drawn levels, their lines, and how many
 *   are left out because they are tiny */

/** Names of the address that switch a curve off. */
const SWITCHES = { tongue: "map.tongue", lift_off: "map.lift" };

/** What lies over the map of a view. */
export class Over {
  /** @param {import("./view.js").MapView} view */
  constructor(view) {
    this.view = view;
    /** @type {NamedLine[]} */
    this.lines = [];
    /** @type {string | null} text of a trial table */
    this.trials = null;
    /** @type {Grid | null} the map whose contour lines are drawn, and what was asked of it */
    this.drawnOn = null;
    this.drawn = "";
  }

  /** Take theory and trials over the map on show; they are drawn with its next picture. */
  place() {
    const { view } = this;
    const { grid } = view;
    if (!grid) return;
    const { over } = view.controls;
    this.lines = [];
    view.chart.trials = null;
    /** @type {string[]} */
    const notes = [];
    const placing = this.attempt(() => new Placing(grid), notes);
    if (placing) {
      for (const curve of [tongue, liftOff]) {
        const line = this.attempt(() => curve(placing), notes);
        if (line) this.lines.push(line);
      }
    }
    over.showCurves(this.lines, notes);
    /** @type {string[]} */
    const refused = [];
    const { trials } = this;
    const placed = trials !== null && placing && this.attempt(() =>
      placedTrials(parseTrials(view.page.registry, trials), placing), refused);
    if (placed) view.chart.trials = placed.trials;
    over.showTrials(placed || null, refused);
  }

  /**
   * The result of a function; if it refuses its input, null, with a sentence among the notes.
   * @template T
   * @param {() => T} make
   * @param {string[]} notes
   */
  attempt(make, notes) {
    try {
      return make();
    } catch (error) {
      if (!(error instanceof InputError)) throw error;
      notes.push(inPagesWords(this.view.page.registry, error)[0]);
      return null;
    }
  }

  /** Return the curves that are switched on. */
  shown() {
    const { extra } = this.view.page.store.state;
    return this.lines.filter(({ name }) =>
      extra[/** @type {Record<string, string>} */ (SWITCHES)[name]] !== "0");
  }

  /**
   * Take the contour lines that the address names once the map grows no more; those of another map
   * go.
   */
  contours() {
    const { grid, chart, controls } = this.view;
    const question = this.question();
    const isLater = this.view.growing();
    const text = JSON.stringify([question, isLater, grid?.done, grid?.complete]);
    if (text === this.drawn && grid === this.drawnOn) return;
    [this.drawn, this.drawnOn] = [text, grid];
    /** @type {string[]} */
    const notes = [];
    const variable = question && grid ? grid.variables[question.variable] : null;
    const drawn = question && grid && !isLater
      ? this.attempt(() => contoursOf(grid, question), notes) : null;
    chart.contours = drawn?.contours ?? [];
    controls.over.showContours(variable, drawn, isLater, notes);
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
    return { variable: grid.variables.indexOf(variable), log,
      levels: extra["map.levels"]?.split(",").map(Number) ?? null };
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
    : roundLevels(...grid.range(variable, log), about.units[0] ?? { name: "", size: 1 }, log)
      .slice(0, MOST_LEVELS);
  const { lines, tiny } = linesOf(grid, variable, all);
  return { levels: all, lines: lines.length, tiny,
    contours: lines.map((line) => ({ ...line, text: withUnit(about, line.level) })) };
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
