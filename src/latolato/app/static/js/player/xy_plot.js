/** A picture of one quantity over another: curves or dots, and marks that move on it. */

import UPlot from "../../vendor/uPlot.js";
import { axisLimits, marksOf, SINGLE } from "./axis.js";
import { axisStyle, FONT } from "./curve_chart.js";
import { colour, el, onLook } from "../page/dom.js";

/** @typedef {{xs: ArrayLike<number>, ys: ArrayLike<number>}} PlotPoints */

const HEIGHT = 0.75; // of the width
// Around the points, as a share of their range.
const MARGIN = 0.06;
// Room for the numbers and for the name of an axis, and the size of a dot, in pixels of the page.
const [BELOW, BESIDE] = [24, 40];
const NAME = 17;
const DOT = 3;

export class XYPlot {
  /**
   * @param {HTMLElement} host
   * @param {{x: string, y: string}} labels
   * @param {string[]} paints of what is shown, from the back to the front
   * @param {{hasDots?: boolean}} [how] whether points are dots, else a line joins them
   */
  constructor(host, labels, paints, { hasDots = false } = {}) {
    this.paints = paints;
    /** @type {Record<string, {x: number, y: number}>} by paint */
    this.marks = {};
    this.dots = paints.map((paint) => el("div", { class: `led fill ${paint}`, hidden: true }));
    const axis = { ...axisStyle(host), labelFont: FONT, labelSize: NAME };
    const options = {
      // Points in any order, of each series its own.
      mode: 2,
      width: 100,
      height: 100 * HEIGHT,
      legend: { show: false },
      cursor: { show: false },
      padding: [8, 12, 0, 0],
      scales: { x: { time: false, range: axisEnds }, y: { range: axisEnds } },
      axes: [
        { ...axis, ...marksOf("width", 70), size: BELOW, label: labels.x },
        { ...axis, ...marksOf("height", 40), size: BESIDE, label: labels.y },
      ],
      series: [{}, ...paints.map((paint) => ({
        [hasDots ? "fill" : "stroke"]: () => colour(paint, host),
        width: 1,
        points: { show: false },
        paths: hasDots ? dots : linePath,
      }))],
      hooks: { draw: [() => this.place()] },
    };
    this.plot = new UPlot(/** @type {any} */ (options), this.dataOf({}), host);
    this.plot.over.append(...this.dots);
    this.release = onLook(host, () => this.plot.redraw(), () => {
      const width = host.clientWidth;
      if (width && width !== this.plot.width) this.plot.setSize({ width, height: HEIGHT * width });
    });
  }

  /**
   * Show points, in limits that hold them all.
   * @param {Record<string, PlotPoints>} points by paint
   */
  show(points) {
    this.plot.setData(this.dataOf(points));
  }

  /**
   * Return points as uPlot takes them.
   * @param {Record<string, PlotPoints>} points by paint
   * @returns {any}
   */
  dataOf(points) {
    return [null, ...this.paints.map((paint) => [points[paint]?.xs ?? [], points[paint]?.ys ?? []])];
  }

  /**
   * Move the marks.
   * @param {Record<string, {x: number, y: number}>} marks by paint
   */
  mark(marks) {
    this.marks = marks;
    this.place();
  }

  /** Put the marks in their places, but for those beyond the axes. */
  place() {
    const { x, y } = this.plot.scales;
    const isOn = (/** @type {{min?: number, max?: number}} */ { min = NaN, max = NaN }, /** @type {number} */ value) =>
      value >= min && value <= max;
    this.dots.forEach((dot, k) => {
      const mark = this.marks[this.paints[k]];
      dot.hidden = !mark || !isOn(x, mark.x) || !isOn(y, mark.y);
      if (dot.hidden) return;
      const [across, down] = [this.plot.valToPos(mark.x, "x"), this.plot.valToPos(mark.y, "y")];
      dot.style.transform = `translate(${across}px, ${down}px)`;
    });
  }

  destroy() {
    this.release();
    this.plot.destroy();
  }
}

/**
 * Return the ends of an axis that holds two values.
 * @param {any} _
 * @param {number} low
 * @param {number} high
 * @returns {[number, number]}
 */
function axisEnds(_, low, high) {
  const [from, to] = axisLimits(low, high, SINGLE);
  const margin = MARGIN * (to - from);
  return [from - margin, to + margin];
}

/**
 * Return the path that joins points; it is broken where one is not finite.
 * @param {any} u
 * @param {number} k number of the series
 */
function linePath(u, k) {
  // uPlot has set round joints, which thin lines do not need and which slow down long ones.
  u.ctx.lineJoin = "miter";
  const stroke = new Path2D();
  let isOpen = false;
  eachPoint(u, k, (x, y) => {
    if (!Number.isFinite(x + y)) isOpen = false;
    else if (isOpen) stroke.lineTo(x, y);
    else {
      stroke.moveTo(x, y);
      isOpen = true;
    }
  });
  return { stroke, fill: null, clip: null, gaps: null, flags: 0 };
}

/**
 * Return the dots of points.
 * @param {any} u
 * @param {number} k number of the series
 */
function dots(u, k) {
  const fill = new Path2D();
  const size = DOT * devicePixelRatio;
  eachPoint(u, k, (x, y) => fill.rect(x - size / 2, y - size / 2, size, size));
  return { stroke: null, fill, clip: null, gaps: null, flags: 0 };
}

/**
 * Call a function with the position of each point of a series, in pixels of the canvas.
 * @param {any} u
 * @param {number} k
 * @param {(x: number, y: number) => void} act
 */
function eachPoint(u, k, act) {
  const [xs, ys] = u.data[k];
  for (let i = 0; i < xs.length; i += 1) act(u.valToPos(xs[i], "x", true), u.valToPos(ys[i], "y", true));
}
