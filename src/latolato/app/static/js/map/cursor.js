/** The cross on a map: where it is, what is known there, and the run of its point. */

import { el, isCalm } from "../page/dom.js";
import { textsOf } from "../page/option_texts.js";
import { Motion } from "../player/motion.js";
import { Preview } from "../player/preview.js";
import { inPagesWords } from "../page/refusals.js";
import { Runner } from "../player/runner.js";
import { t } from "../strings.js";
import { curveText, orbitOptions } from "./overlay_curves.js";
import { cellText, withName } from "./texts.js";

// Beyond it, a run that is computed is announced.
const PATIENCE = 700; // ms

export class Cursor {
  /**
   * @param {import("./view.js").MapView} view
   * @param {HTMLElement} readout
   */
  constructor(view, readout) {
    this.view = view;
    this.readout = readout;
    /** @type {import("./overlay_curves.js").CurvePoint | null} the point of a curve under the cross */
    this.orbit = null;
  }

  /**
   * Say what is known of a place, by default that of the cross.
   * @param {[number, number] | null} [at]
   */
  describe(at = null) {
    const { grid, chart } = this.view;
    const place = at ?? chart.cross;
    const cell = place && grid ? chart.cell(...place) : -1;
    const point = at ? this.view.over.pointAt(at) : this.shownOrbit();
    this.readout.textContent = !grid || cell < 0 ? t("mapHoverHint")
      : point ? curveText(this.view.page.registry, point) : cellText(grid, cell, chart.look.variable);
  }

  /** The point of a curve under the cross, null where that is on a cell or the curve is not on show. */
  shownOrbit() {
    return this.orbit && this.view.over.shownCurves().includes(this.orbit.curve) ? this.orbit : null;
  }

  /**
   * Show the orbit of the curve that is here, or else the run of the cell.
   * @param {number} x
   * @param {number} y
   */
  async pick(x, y) {
    const point = this.view.over.pointAt([x, y]);
    if (point) this.putOn(point);
    else this.put(x, y);
    await this.run();
  }

  /**
   * Put the cross on the nearest point of a curve, or from such a point on the next one, and show its orbit.
   * @param {number} by 1 or -1
   */
  async stepOnCurve(by) {
    const { chart, over } = this.view;
    const point = this.shownOrbit();
    const first = chart.cross && over.pointAt(chart.cross, Infinity);
    if (!point && !first) return;
    const { curve, i } = /** @type {import("./overlay_curves.js").CurvePoint} */ (point ?? first);
    const next = i + (point ? by : 0);
    if (!(chart.cell(curve.xs[next], curve.ys[next]) >= 0)) return;
    this.putOn({ curve, i: next });
    await this.run();
  }

  /**
   * Put the cross on a point of a curve.
   * @param {import("./overlay_curves.js").CurvePoint} point
   */
  putOn({ curve, i }) {
    this.orbit = { curve, i };
    this.view.chart.cross = [curve.xs[i], curve.ys[i]];
    this.view.chart.draw();
    this.describe();
  }

  /**
   * Put the cross on the middle of the cell at these values.
   * @param {number} x
   * @param {number} y
   */
  put(x, y) {
    const { grid, chart } = this.view;
    const cell = chart.cell(x, y);
    if (!grid || cell < 0) return;
    this.orbit = null;
    const column = cell % grid.width;
    chart.cross = [grid.x.values[column], grid.y.values[(cell - column) / grid.width]];
    chart.draw();
    this.describe();
  }

  /** Put the cross where the address has it, if that is on the map. */
  restore() {
    const { chart, page, point } = this.view;
    const at = (page.store.state.extra["map.at"] ?? "").split(",").map(Number);
    this.orbit = null;
    const inside = at.length === 2 && chart.cell(at[0], at[1]) >= 0;
    chart.cross = inside ? [at[0], at[1]] : null;
    if (chart.cross && !point.options) void this.run();
  }

  /**
   * @param {number} columns
   * @param {number} rows
   */
  step(columns, rows) {
    const { grid, chart } = this.view;
    if (!grid) return;
    const [x, y] = chart.cross ?? [grid.x.values[grid.width >> 1], grid.y.values[grid.height >> 1]];
    const cell = Math.max(0, chart.cell(x, y));
    const column = (cell % grid.width) + (chart.cross ? columns : 0);
    const line = Math.floor(cell / grid.width) + (chart.cross ? rows : 0);
    if (column < 0 || column >= grid.width || line < 0 || line >= grid.height) return;
    this.put(grid.x.values[column], grid.y.values[line]);
  }

  /** Show a point to begin with: somewhere in the upper middle. */
  begin() {
    const { grid } = this.view;
    if (!grid) return;
    this.put(grid.x.values[Math.floor(0.5 * grid.width)], grid.y.values[Math.floor(0.7 * grid.height)]);
    void this.run(false);
  }

  /**
   * Show the run of the point under the cross.
   * @param {boolean} [chosen] whether the address keeps the point
   */
  async run(chosen = true) {
    const { grid, chart, page, point } = this.view;
    const orbit = this.shownOrbit();
    // The cross may lie on a curve that has been switched off.
    if (this.orbit && !orbit && chart.cross) this.put(...chart.cross);
    const { cross } = chart;
    if (!cross || !grid) return;
    const { store } = page;
    if (orbit) {
      // The address names cells only.
      const { "map.at": _, ...extra } = store.state.extra;
      store.amend({ extra });
      await point.run(() => orbitOptions(page.registry, orbit), curveText(page.registry, orbit), chosen);
      return;
    }
    if (chosen) store.amend({ extra: { ...store.state.extra, "map.at": cross.join(",") } });
    const words = [withName(grid.x, cross[0]), withName(grid.y, cross[1])];
    const cell = chart.cell(...cross);
    await point.run(() => grid.optionsOf(cell), words.join(" · "), chosen);
  }
}

/** The run of one point of a map, beside it. */
export class PointPanel {
  /**
   * @param {import("../model/registry.js").Registry} registry
   * @param {(options: Record<string, string>) => void} open called with the options of the run
   */
  constructor(registry, open) {
    this.registry = registry;
    /** @type {Record<string, any> | null} options of the run on show, in SI units */
    this.options = null;
    this.runner = new Runner(registry);
    this.preview = new Preview();
    this.preview.root.hidden = true;
    this.title = el("p", { class: "hint", role: "status" }, t("mapPickHint"));
    this.button = el("button", { type: "button", disabled: true,
      on: { click: () => open(textsOf(registry, this.options ?? {})) } }, t("openInToy"));
    this.root = el("aside", { class: "card point" }, el("h2", {}, t("onePoint")), this.title,
      this.preview.root, el("div", { class: "actions" }, this.button));
  }

  /**
   * Show the run of a point.
   * @param {() => Record<string, any>} optionsOf returns its options, or throws why it cannot run
   * @param {string} words what the point is
   * @param {boolean} plays whether it moves at once, unless somebody wants little motion
   */
  async run(optionsOf, words, plays) {
    const waiting = setTimeout(() => { this.title.textContent = t("computing"); }, PATIENCE);
    try {
      const block = await this.runner.compute({ options: optionsOf() });
      this.options = block.about.options;
      this.preview.root.hidden = false;
      this.preview.show(new Motion(block));
      if (plays && !isCalm()) this.preview.clock.play();
      this.title.textContent = words;
      this.button.disabled = false;
      this.root.dataset.runs = String(Number(this.root.dataset.runs ?? 0) + 1);
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return;
      if (!(error instanceof Error)) throw error;
      [this.title.textContent] = inPagesWords(this.registry, error);
      this.button.disabled = true;
    } finally {
      clearTimeout(waiting);
    }
  }
}
