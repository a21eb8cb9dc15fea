/** What is drawn over a map: curves of theory, trials, contour lines. */

import { askBlock, newest } from "../shared/api.js";
import { lookOf } from "./look.js";
import { askedOf, shownMapOf } from "./shown.js";
import { withUnit } from "./tell.js";

/** @typedef {import("./chart.js").Line & {name: string}} NamedLine */
/** @typedef {import("./contours.js").Contour} Contour */
/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Variable} Variable */
/** @typedef {{lines: NamedLine[], trials: import("./chart.js").Trials | null, outside: number,
 *   notes: Record<string, string>}} Found */

const LINES = ["tongue", "lift_off"];
/** Names of the address that switch a curve off. */
const SWITCHES = { tongue: "map.tongue", lift_off: "map.lift" };
/** Stands in the address for contour lines of what has the colours. */
export const OF_COLOURS = "colours";

/** What lies over the map of a view. */
export class Over {
  /** @param {import("./view.js").MapView} view */
  constructor(view) {
    this.view = view;
    /** @type {NamedLine[]} */
    this.lines = [];
    /** @type {string | null} text of a trial table */
    this.trials = null;
    this.asked = "";
    /** @type {Record<string, any> | null} what was asked last: an earlier answer may come later */
    this.latest = null;
    /** @type {Promise<void>} done when theory and trials are there */
    this.settled = Promise.resolve();
    this.ask = newest((/** @type {Record<string, any> | null} */ body) => this.fetch(body));
  }

  /** Return when theory and trials are drawn over the map. */
  draw() {
    this.settled = this.load();
    return this.settled;
  }

  async load() {
    const { view } = this;
    const grid = view.next ?? view.grid;
    if (!grid) return;
    const { xEdges, yEdges, width, height } = grid;
    const limits = [xEdges[0], xEdges[width], yEdges[0], yEdges[height]];
    /** @type {Record<string, any>} */
    const asked = { ...askedOf(view), limits, trials: this.trials };
    if (asked.stored) asked.names = [grid.xAxis.name, grid.yAxis.name];
    this.latest = asked;
    try {
      const found = await askOver(asked);
      if (this.latest !== asked) return;
      this.lines = found.lines;
      view.chart.trials = found.trials;
      view.controls.over.show(found);
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (this.latest !== asked) return;
      view.controls.over.trialNote.textContent = error.message;
    }
    view.repaint();
  }

  /** Return the curves that are switched on. */
  shown() {
    const { extra } = this.view.page.store.state;
    return this.lines.filter(({ name }) =>
      extra[/** @type {Record<string, string>} */ (SWITCHES)[name]] !== "0");
  }

  /**
   * Ask for the contour lines that the address names once the map grows no more; those of another
   * map go.
   */
  contours() {
    const { view } = this;
    const body = view.growing() ? null : this.contourBody();
    const text = JSON.stringify([body, view.grid?.done, view.grid?.complete]);
    if (text === this.asked) return;
    this.asked = text;
    this.ask(body);
  }

  /** Return what contour lines are asked of, null for none. */
  contourBody() {
    const { grid, page } = this.view;
    const { extra } = page.store.state;
    const variable = grid && contourVariable(grid, extra);
    if (!grid || !variable) return null;
    const ofColours = extra["map.contours"] === OF_COLOURS;
    const levels = extra["map.levels"]?.split(",").map(Number) ?? null;
    return { ...shownMapOf(this.view), observable: variable.name, ball: variable.ball, levels,
      log: ofColours && lookOf(grid, extra).log };
  }

  /** @param {Record<string, any> | null} body */
  async fetch(body) {
    const { chart, controls, grid } = this.view;
    const { extra } = this.view.page.store.state;
    const variable = grid && contourVariable(grid, extra);
    /** @type {Contour[]} */
    let found = [];
    let note = null;
    try {
      if (body && variable) {
        const { about, arrays } = await askBlock("api/map/contours", body);
        found = unpacked(arrays, about.levels, (level) => withUnit(variable, level));
        note = about;
      }
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      note = { error: error.message };
    }
    if (this.view.grid !== grid) return;
    chart.contours = found;
    controls.over.showContours(note, variable ?? null);
    chart.draw();
  }
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

/**
 * Return contour lines as they come in a block.
 * @param {Record<string, any>} arrays
 * @param {number[]} levels
 * @param {(level: number) => string} write
 * @returns {Contour[]}
 */
function unpacked({ x, y, first, level }, levels, write) {
  return Array.from(level, (/** @type {number} */ number, i) => ({ level: levels[number],
    text: write(levels[number]), xs: x.subarray(first[i], first[i + 1]),
    ys: y.subarray(first[i], first[i + 1]) }));
}

/**
 * Return what is drawn over a map, and why something is not.
 * @param {Record<string, any>} asked
 * @returns {Promise<Found>}
 */
async function askOver(asked) {
  const { about, arrays } = await askBlock("api/map/overlays", asked);
  return {
    lines: LINES.filter((name) => `${name}_x` in arrays).map((name) => ({ name,
      xs: arrays[`${name}_x`], ys: arrays[`${name}_y`], dashed: name === "lift_off" })),
    trials: arrays.trial_x
      ? { xs: arrays.trial_x, ys: arrays.trial_y, kinds: arrays.trial_class } : null,
    outside: about.outside,
    notes: about.notes,
  };
}
