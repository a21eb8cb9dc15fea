/** How uPlot draws a chart of curves over time: its axes, its scales and what a pointer does. */

import UPlot from "../../vendor/uPlot.js";
import { t } from "../strings.js";
import { axisLimits, SINGLE, UPRIGHT } from "./axis.js";
import { colour } from "../page/dom.js";
import { extremesUntil, pathOf } from "./traces.js";
import { localShort, short } from "../page/unit_text.js";

/** @typedef {import("./curves.js").Panel} Panel */
/** @typedef {import("./traces.js").Curve} Curve */
/**
 * A stretch of time behind curves, in the colour of what it means.
 * @typedef {{from: number, to: number, paint: string}} Shade
 */

/** Of the numbers and names of axes. */
export const FONT = "12px system-ui, sans-serif";
const HEIGHT = 170;
// A wider line takes several times as long to draw without a graphics card.
const WIDTH = 1;
// Room above and below the curves, as a share of their range.
const MARGIN = 0.1;
// How opaque shades are.
const STRENGTH = 0.28;

/**
 * Return how uPlot draws a chart.
 * @param {import("./curves.js").Curves} owner of the chart, whose stretch of time it shows
 * @param {Panel} panel
 * @param {Curve[]} curves
 * @returns {UPlot.Options}
 */
export function chartOptions(owner, panel, curves) {
  const paint = (/** @type {string} */ name) => () => colour(name, owner.root);
  const axis = axisStyle(owner.root);
  const right = curves.find((curve) => curve.axis === "right");
  return {
    width: Math.max(owner.root.clientWidth, 100),
    height: heightOf(panel),
    legend: { show: false },
    padding: [8, right ? 0 : 18, 0, 0],
    scales: {
      x: { time: false, auto: false },
      y: { range: (u, low, high) => limits(...(owner.follows && !owner.motion?.grows
        ? extremesUntil(u, low, high, owner.span[1]) : /** @type {const} */ ([low, high]))) },
      right: { range: (_, low, high) => limits(low, high) },
    },
    cursor: {
      sync: { key: owner.sync, setSeries: false },
      drag: { x: true, y: false, setScale: true },
      points: { show: false },
      bind: {
        // Without Shift a pointer moves the clock.
        mousedown: (_, __, handle) => (e) => {
          if (e.shiftKey) handle(e);
          return null;
        },
        dblclick: () => () => {
          owner.zoom(0, owner.motion?.end ?? 1);
          return null;
        },
      },
    },
    axes: [
      { ...axis, size: 30, values: (/** @type {any} */ _, /** @type {number[]} */ marks) =>
        marks.map((m, k) => (k === marks.length - 1 ? t("seconds", { count: short(m) }) : localShort(m))) },
      { ...axis, ...UPRIGHT },
      ...(right ? [{ ...axis, ...UPRIGHT, scale: "right", side: 1,
        stroke: paint(right.paint), grid: { show: false } }] : []),
    ],
    series: [{}, ...curves.map((curve) => ({
      label: curve.label,
      scale: curve.axis ?? "y",
      stroke: paint(curve.paint),
      width: WIDTH,
      dash: curve.dash,
      points: { show: false },
      paths: (/** @type {any} */ u, /** @type {number} */ k, /** @type {number} */ i0,
        /** @type {number} */ i1) => pathOf(u, k, i0, i1, owner.swing),
    }))],
    hooks: {
      drawAxes: [(/** @type {any} */ u) => {
        if (panel.shades && owner.motion) drawShades(u, panel.shades(owner.motion));
      }],
      setSize: [() => owner.onLayout()],
      setScale: [(/** @type {any} */ u, /** @type {string} */ key) => {
        const { min, max } = u.scales.x;
        // uPlot reports every change at the end of the task, also those that came from here.
        if (key === "x" && (min !== owner.span[0] || max !== owner.span[1])) owner.zoom(min, max);
      }],
    },
  };
}

/**
 * Return how an axis looks in an element.
 * @param {HTMLElement} element
 */
export function axisStyle(element) {
  const grid = { stroke: () => colour("grid", element), width: 1 };
  return { stroke: () => colour("soft", element), grid, ticks: { ...grid, size: 4 }, font: FONT };
}

/** @param {Panel} panel */
export function heightOf({ height = HEIGHT }) {
  return typeof height === "number" ? height : height();
}

/**
 * Return the ends of an axis that holds two values.
 * @param {number} low
 * @param {number} high
 */
function limits(low, high) {
  return UPlot.rangeNum(...axisLimits(low, high, SINGLE), MARGIN, true);
}

/**
 * Draw stretches of time behind the curves of a chart.
 * @param {any} u the uPlot chart
 * @param {Shade[]} shades
 */
export function drawShades(u, shades) {
  const { ctx: context, bbox } = u;
  context.save();
  context.beginPath();
  context.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  context.clip();
  context.globalAlpha = STRENGTH;
  for (const { from, to, paint } of shades) {
    const x = u.valToPos(from, "x", true);
    const width = Math.max(u.valToPos(to, "x", true) - x, 1);
    context.fillStyle = colour(paint, u.root);
    context.fillRect(x, bbox.top, width, bbox.height);
  }
  context.restore();
}
