/** Map: an observable over two parameters, growing from coarse to fine, and runs of its points. */

import { askJson } from "../api.js";
import { codeBlocks } from "../code.js";
import { el, tell } from "../dom.js";
import { Form } from "../form.js";
import { ColourBar } from "../map/bar.js";
import { axisLabel, sizeOf } from "../map/axes.js";
import { MapChart } from "../map/chart.js";
import { MapControls } from "../map/controls.js";
import { Grid } from "../map/grid.js";
import { followHand } from "../map/hand.js";
import { lookOf } from "../map/look.js";
import { MapJob } from "../map/job.js";
import { askOver } from "../map/over.js";
import { PointPanel } from "../map/point.js";
import { requestOf, sameBut, sourceOf } from "../map/request.js";
import { cellText, legend, withName } from "../map/tell.js";
import { Toolbar } from "../map/toolbar.js";
import { movedBy, placeOf, scaledBox, withoutPlace } from "../map/travel.js";
import { t } from "../strings.js";
import { short } from "../units.js";

/** @typedef {import("../main.js").Page} Page */

// Changes of a slider become one request.
const PATIENCE = 120; // ms
// A server that does not answer is asked again after this time.
const RETRY = 1000; // ms

export class MapView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {MapJob | null} */
    this.job = null;
    /** @type {Grid | null} */
    this.grid = null;
    /** @type {Grid | null} what a map that has just begun will show */
    this.next = null;
    /** @type {any} */
    this.choices = null;
    this.wanted = "";
    this.timer = 0;
    /** @type {{grid: Grid, key: string, keys: Record<string, string>}[]} */
    this.zooms = [];
    /** @type {[number, number, number, number] | null} */
    this.known = null;
    /** @type {string | null} */
    this.trials = null;
    this.shown = false;
    this.controls = new MapControls(page.registry, page.store, (text) => {
      this.trials = text;
      void this.drawOver();
    });
    const form = el("form", { class: "form", on: {
      submit: (/** @type {Event} */ e) => e.preventDefault() } });
    this.form = new Form(form, page.registry, page.store);
    this.parameters = el("details", { class: "form" }, el("summary", {}, t("mapParameters")), form);
    this.tools = new Toolbar({ stop: () => this.stopOrGo(), back: () => this.back(),
      scale: (by) => this.scale(by), save: () => this.chart.save() });
    const canvas = el("canvas", { class: "map" });
    const bar = el("canvas", { class: "bar-canvas", role: "img", "aria-label": t("mapBar") });
    this.field = el("div", { class: "map-field", tabindex: "0", role: "application",
      "aria-label": t("mapKeys") }, canvas);
    this.readout = el("p", { class: "map-readout", role: "status", "aria-live": "polite" });
    this.barTitle = el("p", { class: "bar-title" });
    this.classes = el("ul", { class: "legend" });
    this.barBox = el("div", { class: "bar-box" }, this.barTitle, bar, this.classes);
    this.notes = el("p", { class: "error", role: "alert", hidden: true });
    this.point = new PointPanel(page.registry, (options) => this.openInPlay(options));
    this.code = el("div", {});
    this.root = el("div", { class: "view split" },
      el("aside", { class: "side" }, this.controls.top, this.controls.root, this.parameters),
      el("div", { class: "main" }, this.tools.root, this.notes,
        el("div", { class: "map-and-point" },
          el("div", { class: "panel map-panel" }, this.field, this.readout, this.barBox),
          this.point.root),
        el("details", { class: "card" }, el("summary", {}, t("code")),
          el("p", { class: "hint" }, t("mapCodeHint")), this.code)));
    this.chart = new MapChart(canvas);
    this.bar = new ColourBar(bar);
    /** @type {(import("../map/chart.js").Line & {name: string})[]} */
    this.lines = [];
    /** @type {import("../map/travel.js").Moved | null} */
    this.moved = null;
    followHand(this.field, this.chart, {
      hover: (at) => this.tellOf(at ?? this.chart.cross),
      pick: (x, y) => { this.cross(x, y); void this.run(); },
      box: (box) => this.zoom(box),
      pan: (columns, rows) => this.pan(columns, rows),
      back: () => this.back(),
      scale: (by) => this.scale(by),
      step: (columns, rows) => this.step(columns, rows),
      enter: () => void this.run(),
    }, () => this.tools.panning);
    /** @type {() => void} */
    this.unsubscribe = () => {};
  }

  show() {
    this.shown = true;
    this.unsubscribe = this.page.store.subscribe((_, changed) => {
      if (changed !== "view") this.update(changed !== "extra" && changed !== "options");
    });
    void this.findStored();
    const { registry, store } = this.page;
    const { scenario, extra } = store.state;
    // A sweep is no run: other views begin with their own then.
    if (scenario && registry.scenarios[scenario]?.sweep)
      store.set({ scenario: null, extra: { ...extra, "map.scenario": scenario } }, "extra");
    this.update(true);
  }

  hide() {
    this.shown = false;
    this.unsubscribe();
    this.point.preview.rest();
    if (this.grid?.complete && !this.next) return;
    this.stop();
    this.wanted = "";
  }

  async findStored() {
    this.controls.stored = await askJson("/api/map/stored");
    this.controls.showSource(sourceOf(this.page.registry, this.page.store.state));
  }

  /**
   * Show what the address asks for; what must be computed is asked for after a moment.
   * @param {boolean} [now]
   */
  update(now = false) {
    const { registry, store } = this.page;
    const source = sourceOf(registry, store.state);
    this.controls.showSource(source);
    this.parameters.hidden = source.stored !== null;
    const request = requestOf(registry, store.state);
    const has = this.grid && (!request.observable || this.grid.variable(request.observable) >= 0);
    const comes = this.job && !this.job.ended && request.observable === this.job.request.observable;
    if (sameBut(request) === this.wanted && (has || comes)) {
      if (this.choices && request.observable) this.choices.observable = request.observable;
      this.repaint();
      return;
    }
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.compute(request), now ? 0 : PATIENCE);
  }

  /** @param {Record<string, any>} request */
  compute(request) {
    this.stop();
    if (!this.shown) return;
    this.wanted = sameBut(request);
    const known = this.known;
    this.known = null;
    this.tools.say(t("mapBegins"), 0);
    this.job = new MapJob(known ? { ...request, known } : request, {
      choices: (choices) => this.takeChoices(choices),
      phase: (name) => this.tools.say(t(name === "compiling" ? "mapCompiling" : "mapWaiting")),
      begin: (block) => this.begin(new Grid(block), known),
      cells: (block) => this.take(block),
      done: (block) => this.finish(block),
      refused: (text, field) => this.refuse(text, field),
      lost: () => this.retry(),
    });
    this.tools.busy(true);
  }

  /** @param {any} choices */
  takeChoices(choices) {
    this.choices = choices;
    this.controls.showChoices(choices);
    this.form.varied = new Set([choices.x.name, choices.y.name]);
    this.form.show(choices.options);
  }

  /**
   * @param {Grid} grid
   * @param {[number, number, number, number] | null} known
   */
  begin(grid, known) {
    this.notes.hidden = true;
    this.form.error(null);
    this.next = grid;
    if (known && this.moved) grid.takeOver(this.moved.grid, this.moved.columns, this.moved.rows);
    this.moved = null;
    if (known || !grid.about.points) this.change();
    this.showCode(grid.about);
    if (grid.about.select) this.controls.showStored(grid.about);
    void this.drawOver();
  }

  /** Put the map that has begun in the place of the one on show. */
  change() {
    if (!this.next) return;
    this.grid = this.next;
    this.next = null;
    this.chart.grid = this.grid;
    const at = (this.page.store.state.extra["map.at"] ?? "").split(",").map(Number);
    const inside = at.length === 2 && this.chart.cell(at[0], at[1]) >= 0;
    this.chart.cross = inside ? [at[0], at[1]] : null;
    if (this.chart.cross && !this.point.options) void this.run();
  }

  /** @param {import("../block.js").Block} block */
  take(block) {
    this.change();
    const grid = /** @type {Grid} */ (this.grid);
    grid.put(block);
    const { points, rate } = block.about;
    const total = grid.about.points;
    this.tools.say(t("mapRate", { percent: Math.floor((100 * points) / total),
      rate: Math.round(rate), left: Math.ceil((total - points) / (rate || 1)) }), points / total);
    this.repaint();
    this.root.dataset.pictures = String(Number(this.root.dataset.pictures ?? 0) + 1);
  }

  /** @param {import("../block.js").Block} block */
  finish(block) {
    this.change();
    const grid = /** @type {Grid} */ (this.grid);
    grid.complete = true;
    const { points, seconds, rate } = block.about;
    const count = grid.width * grid.height;
    this.tools.say(seconds > 0 ? t("mapDone", { points, seconds: short(seconds, 2),
      rate: Math.round(rate) }) : t("mapKnown", { points: count }), 1);
    this.tools.busy(false);
    this.repaint();
    if (!this.chart.cross) this.showMiddle();
    this.root.dataset.done = String(Number(this.root.dataset.done ?? 0) + 1);
  }

  /**
   * @param {string} text
   * @param {string | null} field
   */
  refuse(text, field) {
    this.notes.hidden = false;
    this.notes.textContent = text;
    if (field && this.form.fields.has(field)) this.form.error(text, field);
    this.tools.say("", 0);
    this.tools.busy(false);
  }

  retry() {
    this.tools.say(t("offline"), 0);
    this.wanted = "";
    this.timer = window.setTimeout(() => this.update(true), RETRY);
  }

  stop() {
    clearTimeout(this.timer);
    if (this.job && !this.job.ended) this.job.cancel();
    this.job = null;
    this.next = null;
  }

  stopOrGo() {
    if (this.job && !this.job.ended) {
      this.stop();
      this.tools.say(t("mapStopped"));
      this.tools.busy(false);
    } else {
      this.wanted = "";
      this.update(true);
    }
  }

  /** Colour the cells anew, and what explains the colours. */
  repaint() {
    const { grid } = this;
    if (!grid) return;
    const { extra } = this.page.store.state;
    const look = lookOf(grid, extra);
    const variable = grid.variables[look.variable];
    this.chart.look = look;
    const lines = this.lines.filter(({ name }) =>
      extra[`map.${name === "tongue" ? "tongue" : "lift"}`] !== "0");
    this.chart.lines = lines;
    this.controls.tongue.box.checked = extra["map.tongue"] !== "0";
    this.controls.lift.box.checked = extra["map.lift"] !== "0";
    this.chart.paint();
    this.controls.showLook(grid, look);
    this.bar.canvas.hidden = variable.classes.length > 0;
    this.barTitle.textContent = axisLabel(variable);
    this.bar.show(look, sizeOf(variable));
    this.classes.replaceChildren(...legend(grid, variable, lines, this.chart.trials !== null));
    this.tools.back.disabled = !this.zooms.length;
    this.tellOf(this.chart.cross);
  }

  /**
   * Say what is known of a place.
   * @param {[number, number] | null} at
   */
  tellOf(at) {
    const { grid } = this;
    const cell = at && grid ? this.chart.cell(...at) : -1;
    if (!grid || cell < 0) {
      this.readout.textContent = t("mapHoverHint");
      return;
    }
    this.readout.textContent = cellText(grid, cell, this.chart.look.variable);
  }

  /**
   * Put the cross on the middle of the cell at these values.
   * @param {number} x
   * @param {number} y
   */
  cross(x, y) {
    const grid = /** @type {Grid} */ (this.grid);
    const cell = this.chart.cell(x, y);
    if (cell < 0) return;
    const column = cell % grid.width;
    this.chart.cross = [grid.x[column], grid.y[(cell - column) / grid.width]];
    this.chart.draw();
    this.tellOf(this.chart.cross);
  }

  /**
   * @param {number} columns
   * @param {number} rows
   */
  step(columns, rows) {
    const { grid } = this;
    if (!grid) return;
    const [x, y] = this.chart.cross ?? [grid.x[grid.width >> 1], grid.y[grid.height >> 1]];
    const cell = Math.max(0, this.chart.cell(x, y));
    const column = (cell % grid.width) + (this.chart.cross ? columns : 0);
    const line = Math.floor(cell / grid.width) + (this.chart.cross ? rows : 0);
    if (column < 0 || column >= grid.width || line < 0 || line >= grid.height) return;
    this.cross(grid.x[column], grid.y[line]);
  }

  /** Show a point to begin with: somewhere in the upper middle. */
  showMiddle() {
    const grid = /** @type {Grid} */ (this.grid);
    this.cross(grid.x[Math.floor(0.5 * grid.width)], grid.y[Math.floor(0.7 * grid.height)]);
    void this.run(false);
  }

  /** Return the request for things about this map: the plan, and names of axes of a stored one. */
  asked() {
    const { grid } = this;
    const request = requestOf(this.page.registry, this.page.store.state);
    if (request.stored)
      return { stored: request.stored, select: request.select,
        names: [grid?.xAxis.name, grid?.yAxis.name] };
    return { ...request, x: this.choices?.x ?? request.x, y: this.choices?.y ?? request.y };
  }

  /**
   * Show the run of the point under the cross.
   * @param {boolean} [chosen] whether the address keeps the point
   */
  async run(chosen = true) {
    const { cross } = this.chart;
    if (!cross || !this.grid) return;
    if (chosen) this.controls.keep({ at: cross.join(",") });
    const words = [withName(this.grid.xAxis, cross[0]), withName(this.grid.yAxis, cross[1])];
    await this.point.run({ ...this.asked(), at: cross }, words.join(" · "));
  }

  /** @param {Record<string, string>} options */
  openInPlay(options) {
    const { registry, store } = this.page;
    const { scenario } = sourceOf(registry, store.state);
    const extra = { ...store.state.extra };
    // The way back leads to the same map.
    if (scenario) extra["map.scenario"] = scenario;
    store.set({ view: "play", scenario: null, options, extra }, "view");
  }

  /** Draw theory and trials over the map. */
  async drawOver() {
    const grid = this.next ?? this.grid;
    if (!grid) return;
    const { xEdges, yEdges, width, height } = grid;
    const limits = [xEdges[0], xEdges[width], yEdges[0], yEdges[height]];
    const asked = { ...this.asked(), limits, trials: this.trials };
    if (asked.stored) asked.names = [grid.xAxis.name, grid.yAxis.name];
    try {
      const over = await askOver(asked);
      this.lines = over.lines;
      this.chart.trials = over.trials;
      this.controls.showOver(over);
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      this.controls.trialNote.textContent = error.message;
    }
    this.repaint();
  }

  /**
   * Go on with a part of the map in its place.
   * @param {import("../map/chart.js").Box} box
   */
  zoom([x0, x1, y0, y1]) {
    const { grid } = this;
    if (!grid || this.asked().stored) return tell(t("mapStoredZoom"));
    const keys = placeOf(this.page.store.state.extra);
    this.zooms.push({ grid, key: this.wanted, keys });
    this.controls.keep({ x: grid.xAxis.name, y: grid.yAxis.name,
      xlow: x0, xhigh: x1, ylow: y0, yhigh: y1 });
  }

  /** Zoom out to the map before, which is still there. */
  back() {
    const last = this.zooms.pop();
    if (!last) return;
    const kept = withoutPlace(this.page.store.state.extra);
    this.stop();
    if (last.grid.complete) {
      this.wanted = last.key;
      this.grid = this.chart.grid = last.grid;
      this.tools.say(t("mapKnown", { points: last.grid.width * last.grid.height }), 1);
    }
    this.page.store.set({ extra: { ...kept, ...last.keys } }, "extra");
    void this.drawOver();
  }

  /** @param {number} by factor of the lengths of both axes */
  scale(by) {
    const { grid } = this;
    if (!grid) return;
    this.zoom(scaledBox(grid, by, this.chart.cross));
  }

  /**
   * Move to the cells beside; those that are known stay.
   * @param {number} columns
   * @param {number} rows
   */
  pan(columns, rows) {
    const { grid } = this;
    if (!grid || this.asked().stored || (!columns && !rows)) return;
    const { box, moved, known } = movedBy(grid, columns, rows);
    this.moved = moved;
    this.known = known;
    this.controls.keep({ x: grid.xAxis.name, y: grid.yAxis.name,
      xlow: box[0], xhigh: box[1], ylow: box[2], yhigh: box[3] });
  }

  /** @param {any} about */
  showCode(about) {
    this.code.replaceChildren(...codeBlocks([about.python, about.command]));
  }
}
