/**
 * Curves over time, one below the other, with one zoom and the clock's instant in all: a pointer that
 * is dragged over them moves the clock.
 */

import UPlot from "../../vendor/uPlot.js";
import { t } from "../strings.js";
import { axisLimits } from "./axis.js";
import { chartOptions, heightOf } from "./curve_chart.js";
import { el, freshId, onLook } from "../page/dom.js";
import { followKeys } from "../page/keys.js";
import { sayOffline } from "../page/messages.js";
import { followPointer, Playhead } from "./playhead.js";
import { dataOf, resampled } from "./traces.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./clock.js").Clock} Clock */
/** @typedef {import("./traces.js").Curve} Curve */
/**
 * A quantity ("angle", "energy", "power") lets a chart be described in a sentence.
 * @typedef {{label: string | ((motion: Motion) => string), quantity?: string,
 *   height?: number | (() => number), curves: (motion: Motion) => Curve[],
 *   shades?: (motion: Motion) => import("./curve_chart.js").Shade[]}} Panel
 */

// While the clock is followed, so many natural periods of a run are shown, or all of one that is
// little longer: they are more than this share of it.
const SWINGS = 12;
const MOST = 0.75;
// The curve stands still and turns like a page: scrolling would draw all charts again for each
// picture. This share of a new page is what was seen before.
const KEPT = 0.25;
// A motion that grows: so much of it is shown, and as many pictures pass until it is drawn again.
const LAST = 15; // s
const PICTURES = 2;
// A notch of the wheel, with Ctrl held, shows so much less or more.
const WHEEL = 1.3;

export class Curves {
  /**
   * @param {HTMLElement} root
   * @param {Clock} clock
   * @param {Panel[]} panels
   * @param {{follows?: boolean}} [how] whether a readable stretch is shown that follows the
   *   clock, until somebody zooms
   */
  constructor(root, clock, panels, { follows = false } = {}) {
    this.root = root;
    this.clock = clock;
    this.panels = panels;
    this.follows = follows;
    /** Called with the stretch of time on show, and with one that somebody chose. */
    this.onSpan = this.onZoom = (/** @type {number} */ _from, /** @type {number} */ _to) => {};
    /** Called when the charts were laid out again. */
    this.onLayout = () => {};
    /** Returns balls that are led, in place of the instant of the run. @type {() => import("./motion.js").Pose | null} */
    this.held = () => null;
    /** @type {Motion | null} */
    this.motion = null;
    /** @type {Motion | null} */
    this.pinned = null;
    /** @type {{plot: any, playhead: Playhead, curves: Curve[],
     *   host: HTMLElement, panel: Panel}[]} */
    this.charts = [];
    /** What is still to be done for the run on show. @type {(() => void)[]} */
    this.tasks = [];
    /** @type {[number, number]} */
    this.span = [0, 1];
    /** Pictures since a motion that grows was drawn. */
    this.pictures = 0;
    this.signature = "";
    // Pointers are shown together within these charts only: other charts have times of their own.
    this.sync = freshId();
    const zoomBy = (/** @type {number} */ share) => {
      const [from, to] = this.span;
      const middle = Math.min(Math.max(this.clock.time, from), to);
      this.zoom(middle - 0.5 * share * (to - from), middle + 0.5 * share * (to - from));
    };
    const panBy = (/** @type {number} */ share) => this.pan(share * (this.span[1] - this.span[0]));
    /** @type {import("../page/keys.js").KeyActions} */
    this.actions = {
      "+": { text: "keyCloser", act: () => zoomBy(0.5) },
      "-": { text: "keyFarther", act: () => zoomBy(2) },
      "0": { text: "keyWhole", act: () => this.zoom(0, this.motion?.end ?? 1) },
      ArrowLeft: { text: "keyEarlier", act: () => panBy(-0.2) },
      ArrowRight: { text: "keyLater", act: () => panBy(0.2) },
    };
    this.unsubscribe = clock.subscribe((time) => this.move(time));
    this.release = onLook(root, () => this.charts.forEach(({ plot }) => plot.redraw()), () => this.resize());
  }

  /**
   * Show a run, and a pinned one behind it: the first chart at once, the others in the next moments,
   * and then what else shows the run.
   * @param {Motion} motion
   * @param {Motion | null} [pinned]
   * @param {(() => void)[]} [others]
   */
  show(motion, pinned = null, others = []) {
    const wasWhole = !this.motion || this.isWhole;
    this.motion = motion;
    this.pinned = pinned;
    const all = this.panels.map((panel) => this.curvesOf(panel, motion, pinned));
    const signature = JSON.stringify(this.panels.map((panel, i) =>
      [labelOf(panel, motion), all[i].map(({ label, axis }) => [label, axis])]));
    if (signature !== this.signature) {
      this.build(all);
      this.signature = signature;
    }
    if (motion.grows) this.span = lastOf(motion);
    else if (this.follows) this.span = this.stretch(this.span[0]);
    else if (wasWhole) this.span = axisLimits(0, motion.end);
    else this.span = axisLimits(this.span[0], Math.min(this.span[1], motion.end));
    if (this.follows && !motion.grows) this.span = this.spanAt(this.clock.time);
    this.onSpan(...this.span);
    const tasks = this.charts.map((chart, i) => () => {
      this.fill(chart, all[i]);
      this.placeLater();
      this.read(this.clock.time);
    });
    tasks[0]?.();
    this.doLater([...tasks.slice(1), () => void this.describe(motion), ...others]);
  }

  /**
   * Do tasks one after the other, each in a moment of its own, unless newer ones come.
   * @param {(() => void)[]} tasks
   */
  doLater(tasks) {
    this.tasks = tasks;
    const next = () => {
      if (this.tasks !== tasks) return;
      tasks.shift()?.();
      if (tasks.length) setTimeout(next);
    };
    // One frame draws what is already done; the next one begins when that is painted.
    requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(next)));
  }

  /**
   * Say in words what the charts show.
   * @param {Motion} motion
   */
  async describe(motion) {
    const describe = await import("./describe.js").catch(sayOffline);
    if (!describe || this.motion !== motion) return;
    for (const { host, panel, curves } of this.charts) {
      if (!panel.quantity) continue;
      const own = curves.filter(({ paint, axis }) => paint !== "faint" && !axis).map(({ values }) => values);
      const text = describe.inText([describe.curvesOf(panel.quantity, own)]);
      host.setAttribute("aria-label", `${nameOf(labelOf(panel, motion), curves)}. ${text}`);
    }
  }

  /**
   * @param {Panel} panel
   * @param {Motion} motion
   * @param {Motion | null} pinned
   */
  curvesOf(panel, motion, pinned) {
    const own = panel.curves(motion);
    if (!pinned) return own;
    const old = panel.curves(pinned).map((curve) => ({
      ...curve,
      label: `${curve.label}, ${t("pinned")}`,
      paint: "faint",
      ofPose: undefined,
      values: resampled(pinned.time, curve.values, motion.time),
    }));
    return [...old, ...own];
  }

  /** @param {Curve[][]} all */
  build(all) {
    for (const { plot } of this.charts) plot.destroy();
    this.root.replaceChildren();
    const motion = /** @type {Motion} */ (this.motion);
    this.charts = this.panels.map((panel, i) => {
      const label = labelOf(panel, motion);
      const playhead = new Playhead(all[i]);
      const legend = el("ul", { class: "legend" }, ...all[i].map((curve, k) => {
        const key = el("span", { class: `key ${curve.paint}` });
        return el("li", {}, key, curve.label, " ", playhead.values[k]);
      }));
      const host = el("div", {
        class: "chart", tabindex: "0", role: "img", "aria-label": nameOf(label, all[i]),
        on: {
          wheel: (/** @type {WheelEvent} */ e) => this.wheel(e),
        },
      });
      followKeys(host, this.actions);
      this.root.append(el("figure", { class: "panel" },
        el("figcaption", {}, el("strong", {}, label), legend), host));
      // Empty: `show` fills one chart after the other.
      const plot = new UPlot(chartOptions(this, panel, all[i]), [[], ...all[i].map(() => [])], host);
      plot.over.append(playhead.line, ...playhead.dots);
      followPointer(plot, this.clock);
      return { plot, playhead, curves: all[i], host, panel };
    });
    this.resize();
  }

  /** Whether the whole run is shown. */
  get isWhole() {
    return this.span[0] <= 0 && this.span[1] >= (this.motion?.end ?? 1);
  }

  /** The natural period [s]. */
  get swing() {
    return (2 * Math.PI) / (this.motion?.about.attributes?.natural_frequency ?? 0);
  }

  /** How long a stretch is shown while the clock is followed: of a short run, all of it [s]. */
  get readable() {
    const { end = 1 } = this.motion ?? {};
    const length = SWINGS * this.swing;
    return length < MOST * end ? length : end;
  }

  /**
   * Return a readable stretch that begins at an instant, or as late as the run allows.
   * @param {number} from
   * @returns {[number, number]}
   */
  stretch(from) {
    const { readable } = this;
    const begin = Math.min(Math.max(from, 0), (this.motion?.end ?? 1) - readable);
    return axisLimits(begin, begin + readable);
  }

  /** Follow the clock from now on. */
  follow() {
    this.follows = true;
    this.setSpan(...this.stretch(this.clock.time - 0.5 * this.readable));
  }

  /**
   * Return the stretch to show at an instant: the same one as long as the instant lies in it.
   * @param {number} time
   */
  spanAt(time) {
    const [from, to] = this.span;
    return time >= from && time <= to ? this.span : this.stretch(time - KEPT * (to - from));
  }

  /**
   * Show a stretch of time in all charts, and stay there.
   * @param {number} from
   * @param {number} to
   */
  zoom(from, to) {
    if (!this.motion || this.motion.grows || !(to > from)) return;
    const least = this.motion.end * 1e-6;
    this.follows = false;
    this.setSpan(Math.max(0, from), Math.min(this.motion.end, Math.max(to, from + least)));
    this.onZoom(...this.span);
  }

  /**
   * @param {number} from
   * @param {number} to
   */
  setSpan(from, to) {
    this.span = [from, to];
    for (const { plot } of this.charts) plot.setScale("x", { min: from, max: to });
    this.onSpan(from, to);
    this.placeLater();
  }

  /**
   * Zoom about the pointer with Ctrl, move with Shift or a sideways wheel; else the page scrolls.
   * @param {WheelEvent} event
   */
  wheel(event) {
    const [from, to] = this.span;
    const sideways = event.shiftKey ? event.deltaY || event.deltaX : event.deltaX;
    if (event.ctrlKey) {
      const by = event.deltaY > 0 ? WHEEL : 1 / WHEEL;
      const left = this.charts.map(({ plot }) => plot.cursor.left).find((x) => x >= 0);
      const at = left === undefined ? 0.5 * (from + to) : this.charts[0].plot.posToVal(left, "x");
      this.zoom(at - (at - from) * by, at + (to - at) * by);
    } else if (sideways) this.pan(0.1 * Math.sign(sideways) * (to - from));
    else return;
    event.preventDefault();
  }

  /** @param {number} by */
  pan(by) {
    const end = this.motion?.end ?? 1;
    const [from, to] = this.span;
    const shift = Math.min(Math.max(by, -from), end - to);
    this.zoom(from + shift, to + shift);
  }

  /** Show the last seconds of a motion that has grown. */
  grow() {
    const motion = /** @type {Motion} */ (this.motion);
    this.pictures = (this.pictures + 1) % PICTURES;
    if (this.pictures && this.clock.playing) return;
    this.span = lastOf(motion);
    for (const chart of this.charts) this.fill(chart, chart.panel.curves(motion));
    this.placeLater();
  }

  /**
   * Draw the stretch on show of curves in their chart.
   * @param {Curves["charts"][number]} chart
   * @param {Curve[]} curves
   */
  fill(chart, curves) {
    chart.curves = curves;
    const [min, max] = this.span;
    chart.plot.batch(() => {
      chart.plot.setData(dataOf(/** @type {Motion} */ (this.motion), curves), false);
      chart.plot.setScale("x", { min, max });
    });
  }

  /** @param {number} time */
  move(time) {
    if (!this.motion) return;
    if (this.motion.grows) {
      this.grow();
      if (this.clock.isRead) this.read(time);
      return;
    }
    const span = this.follows ? this.spanAt(time) : this.span;
    if (span[0] !== this.span[0]) this.setSpan(...span);
    else this.place();
    if (this.clock.isRead) this.read(time);
  }

  /** Put the clock's instant into the charts. */
  place() {
    const held = this.held();
    for (const { plot, playhead, curves } of this.charts) playhead.place(plot, curves, this.clock.time, held);
  }

  /** The same when uPlot has set the scales, which it does at the end of the task. */
  placeLater() {
    queueMicrotask(() => this.place());
  }

  /**
   * Write the values of an instant into the legends.
   * @param {number} time
   */
  read(time) {
    const held = this.held();
    for (const { playhead, curves } of this.charts)
      if (this.motion) playhead.read(this.motion, curves, time, held, this.clock.lag);
  }

  resize() {
    if (!this.root.clientWidth) return;
    const widths = this.charts.map(({ host }) => host.clientWidth);
    for (const [i, { plot, panel }] of this.charts.entries()) {
      const [width, height] = [widths[i], heightOf(panel)];
      if (plot.width !== width || plot.height !== height) plot.setSize({ width, height });
    }
    this.place();
  }

  destroy() {
    this.unsubscribe();
    this.release();
    this.tasks = [];
    for (const { plot } of this.charts) plot.destroy();
  }
}

/**
 * Return the stretch that is shown of a motion that grows: it fills up, and then goes along.
 * @param {Motion} motion
 * @returns {[number, number]}
 */
const lastOf = ({ end }) => [Math.max(0, end - LAST), Math.max(end, LAST)];

/**
 * Return the name of a chart.
 * @param {string} label
 * @param {Curve[]} curves
 */
const nameOf = (label, curves) => `${label}: ${curves.map((curve) => curve.label).join(", ")}`;

/**
 * @param {Panel} panel
 * @param {Motion} motion
 */
function labelOf({ label }, motion) {
  return typeof label === "string" ? label : label(motion);
}
