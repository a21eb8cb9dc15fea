/** Map: an observable over two parameters, growing from coarse to fine, and runs of its points. */

import { InputError } from "../model/rules.js";
import { askJson } from "../page/api.js";
import { codeBlocks } from "../page/code.js";
import { el } from "../page/dom.js";
import { Form } from "../page/form.js";
import { followKeys, KeyList } from "../page/keys.js";
import { leaveOut, sentence, waysBack } from "../page/link_parts.js";
import { inPagesWords } from "../page/refusals.js";
import { t } from "../strings.js";
import { misread, openInPlay, requestOf, sameBut, sourceOf, USUAL_SIZE, withMapNamed } from "./address.js";
import { axisLabel, sizeOf } from "./axes.js";
import { ColourBar } from "./bar.js";
import { MapChart } from "./chart.js";
import { lookOf } from "./colours.js";
import { MapControls } from "./controls.js";
import { Cursor, PointPanel } from "./cursor.js";
import { gridOf } from "./about.js";
import { MapFiles } from "./exports.js";
import { followHand } from "./pointer.js";
import { KnownMaps } from "./known.js";
import { ownMap, storedMap } from "./open.js";
import { contourVariable, Over } from "./over.js";
import { Pool } from "./pool.js";
import { doneText, legend } from "./texts.js";
import { Toolbar } from "./toolbar.js";

/** @typedef {import("../page/state.js").Page} Page */
/** @typedef {import("./question.js").MapQuestion} MapQuestion */

// Changes of a slider become one request.
const PATIENCE = 120; // ms

export class MapView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    this.pool = new Pool();
    void this.pool.warm("lanes");
    this.known = new KnownMaps();
    /** Ends the map on its way. @type {AbortController | null} */
    this.run = null;
    /** @type {Record<string, any>} what the map on show answers, and its question if it is computed */
    this.request = {};
    /** @type {MapQuestion | null} */
    this.question = null;
    /** @type {import("./grid.js").Grid | null} */
    this.grid = null;
    /** The last request of a map, null if it was refused or stopped. @type {Record<string, any> | null} */
    this.asked = null;
    this.timer = 0;
    this.shown = false;
    this.over = new Over(this);
    this.controls = new MapControls(page.registry, page.store, (files) => this.over.take(files));
    const form = el("form", { class: "form" });
    form.addEventListener("submit", (e) => e.preventDefault());
    this.form = new Form(form, page.registry, page.store, () => withMapNamed(page.registry, page.store.state));
    this.parameters = el("details", { class: "form" }, el("summary", {}, t("mapParameters")), form);
    this.tools = new Toolbar(this);
    const canvas = el("canvas", { class: "map" });
    const bar = el("canvas", { class: "bar-canvas", role: "img", "aria-label": t("mapBar") });
    this.field = el("div", { class: "map-field", tabindex: "0", role: "application",
      "aria-label": t("mapKeys") }, canvas);
    const readout = el("p", { class: "map-readout", role: "status", "aria-live": "polite" });
    this.barTitle = el("p", { class: "bar-title" });
    this.classes = el("ul", { class: "legend" });
    const barBox = el("div", { class: "bar-box" }, this.barTitle, bar, this.classes);
    this.point = new PointPanel(page.registry, (options) => openInPlay(page, options));
    this.files = new MapFiles(this);
    this.code = el("div", {});
    this.root = el("div", { class: "view split" },
      el("aside", { class: "side" }, this.controls.top, this.controls.root, this.parameters),
      el("div", { class: "main" },
        el("div", { class: "map-head" }, this.tools.root, el("div", { class: "stage-tools" })),
        el("div", { class: "stage-messages" }),
        el("div", { class: "map-and-point" },
          el("div", { class: "panel map-panel" }, this.field, readout, barBox), this.point.root),
        this.files.root,
        el("details", { class: "card" }, el("summary", {}, t("code")),
          el("p", { class: "hint" }, t("mapCodeHint")), this.code)));
    this.chart = new MapChart(canvas);
    this.bar = new ColourBar(bar);
    this.cursor = new Cursor(this, readout);
    const keys = followHand(this);
    this.keys = new KeyList(() => [{ title: t("keysHere"), actions: { ...keys, ...this.help } }]);
    /** @type {import("../page/keys.js").KeyActions} */
    this.help = { "?": { text: "keyHelp", act: () => this.keys.open() } };
    readout.after(this.keys.root);
    /** @type {(() => void)[]} what ends listening */
    this.releases = [];
  }

  show() {
    this.shown = true;
    this.releases.push(followKeys(document, this.help), this.page.store.subscribe((_, changed) => {
      if (changed !== "view") this.update(changed !== "extra" && changed !== "options");
    }));
    if (this.page.registry.server) void this.findStored();
    const { registry, store } = this.page;
    const { scenario, extra } = store.state;
    // A sweep is no run: other views begin with their own then.
    if (scenario && registry.scenarios[scenario]?.sweep)
      store.amend({ scenario: null, extra: { ...extra, "map.scenario": scenario } });
    leaveOut(this.page, misread(registry, store.state.extra));
    this.update(true);
  }

  hide() {
    this.shown = false;
    for (const release of this.releases.splice(0)) release();
    this.point.preview.rest();
    this.files.stop();
    if (this.run) this.asked = null;
    this.stop();
  }

  /** Return a picture of the map, null before there is one. */
  picture() {
    return this.grid ? import("./image.js").then(({ pictureOf }) => pictureOf(this)) : null;
  }

  async findStored() {
    this.controls.stored = await askJson("api/map/stored");
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
    this.controls.showSize();
    this.parameters.hidden = source.stored !== null;
    this.tools.show(source.stored !== null);
    const request = requestOf(registry, store.state);
    const { asked } = this;
    const has = !request.observable || (this.grid?.variable(request.observable) ?? -1) >= 0;
    const comes = this.run && request.observable === asked?.observable;
    if (asked && sameBut(request) === sameBut(asked) && (has || comes)) {
      this.repaint();
      return;
    }
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.open(request), now ? 0 : PATIENCE);
  }

  /**
   * Compute a map, or open a stored one; the picture of the one before pales until there is another.
   * @param {Record<string, any>} request
   */
  async open(request) {
    this.stop();
    if (!this.shown) return;
    const { signal } = this.run = new AbortController();
    this.asked = request;
    this.tools.showProgress(t("mapBegins"), 0);
    this.tools.state("busy");
    this.page.messages.drop("map");
    this.controls.refuse(null);
    this.veil(this.grid !== null);
    try {
      await (request.stored ? this.openStored(request, signal) : this.compute(/** @type {any} */ (request), signal));
    } catch (error) {
      if (signal.aborted) return;
      this.run = null;
      this.refuse(/** @type {Error} */ (error));
    }
  }

  /**
   * @param {Record<string, any>} request
   * @param {AbortSignal} signal
   */
  async openStored(request, signal) {
    const { registry } = this.page;
    if (!registry.server) throw new Error(t("mapStoredProgram"));
    const grid = await storedMap(registry, request, signal);
    this.controls.showStored(grid);
    this.begin(grid.about);
    this.change(grid, request, null);
    this.finish(grid);
  }

  /**
   * @param {import("./question.js").MapRequest} request
   * @param {AbortSignal} signal
   */
  async compute(request, signal) {
    const { question, estimate } = await ownMap(this.page.registry, this.pool, request, (chosen) => {
      signal.throwIfAborted();
      this.controls.showChoices(chosen);
      this.form.varied = new Set([chosen.x.name, chosen.y.name]);
      this.form.show(chosen.options);
    });
    signal.throwIfAborted();
    const grid = gridOf(question);
    this.begin(grid.about);
    this.known.add(grid, question.plan);
    if (grid.done) this.change(grid, request, question);
    const progress = await this.pool.compute(question.plan, estimate, {
      stride: request.stride, isKnown: (cell) => grid.isKnown(cell),
      onCells: (cells, { rate, share }) => {
        grid.put(cells);
        this.tools.showProgress(t("mapRate", { percent: Math.floor(100 * share), rate: Math.round(rate) }), share);
        this.change(grid, request, question);
      },
    });
    signal.throwIfAborted();
    this.finish(grid, progress);
  }

  /**
   * Dim the picture, or restore it.
   * @param {boolean} isOld
   */
  veil(isOld) {
    this.chart.isOld = isOld;
    this.root.classList.toggle("old", isOld);
    this.chart.draw();
  }

  /** Return whether a map is on its way. */
  growing() {
    return this.run !== null;
  }

  /** @param {import("./grid.js").MapAbout} about */
  begin({ python, command }) {
    this.form.error(null);
    this.code.replaceChildren(...codeBlocks([python, command]));
  }

  /**
   * Show the cells of a map; the first ones put it in the place of the one on show.
   * @param {import("./grid.js").Grid} grid
   * @param {Record<string, any>} request
   * @param {MapQuestion | null} question
   */
  change(grid, request, question) {
    if (grid !== this.grid) {
      this.grid = this.chart.grid = grid;
      this.request = request;
      this.question = question;
      this.chart.contours = [];
      this.chart.isOld = false;
      this.root.classList.remove("old");
      this.cursor.restore();
      this.over.place();
    }
    this.repaint();
    this.root.dataset.pictures = String(Number(this.root.dataset.pictures ?? 0) + 1);
  }

  /**
   * @param {import("./grid.js").Grid} grid
   * @param {import("./pool.js").Progress} [progress] of a map that was computed
   */
  finish(grid, progress) {
    this.run = null;
    this.tools.showProgress(doneText(grid, progress), 1);
    this.tools.state(grid.done < grid.width * grid.height ? "coarse" : "done");
    this.repaint();
    if (!this.chart.cross) this.cursor.begin();
    this.root.dataset.done = String(Number(this.root.dataset.done ?? 0) + 1);
  }

  /** @param {Error} error */
  refuse(error) {
    const { options, ...others } = this.form.registryInWords;
    const { duration } = options;
    const times = { duration: { ...duration, label: t("mapDuration") },
      transient: { ...duration, label: t("mapTransient") } };
    const registry = { ...others, options: { ...options, ...times } };
    const [text, field] = inPagesWords(registry, error);
    const said = sentence(registry, error);
    const own = error instanceof InputError ? error.about.fields ?? [] : [];
    this.controls.refuse(said, field === null ? own : [...own, field]);
    this.page.messages.show("map", said,
      { stays: true, isBad: true, actions: waysBack(this.page, error) });
    // It is refused again where the map is shown again.
    this.asked = null;
    if (field && this.form.fields.has(field)) this.form.error(text, field);
    this.tools.showProgress("", 0);
    this.tools.state("done");
  }

  stop() {
    clearTimeout(this.timer);
    this.run?.abort();
    this.run = null;
    this.pool.stop();
  }

  stopOrGo() {
    if (this.tools.now === "coarse") this.controls.keep({ size: USUAL_SIZE });
    else if (this.run) {
      this.stop();
      this.tools.showProgress(t("mapStopped"));
      this.tools.state("stopped");
      this.repaint();
    } else {
      this.asked = null;
      this.update(true);
    }
  }

  /** Colour the cells again, and what explains the colours. */
  repaint() {
    const { grid, chart } = this;
    if (!grid) return;
    const { extra } = this.page.store.state;
    const look = lookOf(grid, extra);
    const variable = grid.variables[look.variable];
    chart.look = look;
    chart.lines = this.over.shown();
    this.controls.showLook(grid, look);
    this.controls.over.showChoices(grid, extra, this.over.off());
    this.bar.canvas.hidden = variable.classes.length > 0;
    this.barTitle.textContent = axisLabel(variable);
    this.bar.show(look, sizeOf(variable));
    this.classes.replaceChildren(...legend(grid, look, { lines: chart.lines, trials: chart.trials !== null, contours: contourVariable(grid, extra), registry: this.page.registry }));
    this.cursor.describe();
    this.over.contours();
    chart.paint();
  }
}
