/** What lies over the cells of a map: curves, trials and the cross. */

import { colour } from "../page/dom.js";
import { outline } from "../player/canvas.js";

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {import("./chart.js").Trials} Trials */

const SIGN = 15; // pixels of the page
// A curve of bifurcations has its colour on white on black: one of them shows on any cells.
const DARK = "#1f2430";
const LIGHT = "#ffffff";
/**
 * Signs of special points of curves, by matplotlib's names of their marks, and of classes of trials.
 * @type {Record<string, string>}
 */
export const SIGNS = { v: "▼", s: "■", D: "◆", p: "⬟", o: "●", "^": "▲", X: "✖",
  none: "●", weak: "▲", strong: "◆" };
/** Classes of trials, by the number that sweeps give them. */
export const CLASSES = ["none", "weak", "strong"];

/**
 * Draw a line that shows on dark and on light cells: solid where stable motions end, dashed elsewhere, with
 * its special points.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {import("./overlay_curves.js").Line} line
 * @param {number} ratio
 */
export function drawLine(chart, context, { xs, ys, edges, colour: paint, marks }, ratio) {
  const [solid, dashed] = [new Path2D(), new Path2D()];
  for (let begin = 0; begin < edges.length;) {
    let end = begin + 1;
    while (end < edges.length && edges[end] === edges[begin]) end += 1;
    // A piece reaches to the first point of the next one, so that no gap is left.
    addLine(chart, edges[begin] ? solid : dashed, xs, ys, begin, Math.min(end + 1, xs.length));
    begin = end;
  }
  for (const path of [solid, dashed]) {
    const dash = path === dashed ? [6 * ratio, 4 * ratio] : [];
    if (paint) outline(context, path, [DARK, 5.6 * ratio], [LIGHT, 4.2 * ratio], [paint, 2.4 * ratio, dash]);
    else outline(context, path, [DARK, 3.6 * ratio], [LIGHT, 1.8 * ratio, dash]);
  }
  for (const { x, y, mark } of marks) {
    const [left, top] = chart.place(x, y);
    drawSign(context, SIGNS[mark] ?? SIGNS.o, left, top, ratio, paint);
  }
}

/**
 * Add points of a line to a path.
 * @param {MapChart} chart
 * @param {Path2D} path
 * @param {ArrayLike<number>} xs
 * @param {ArrayLike<number>} ys
 * @param {number} begin
 * @param {number} end
 */
function addLine(chart, path, xs, ys, begin, end) {
  const { top, height } = chart.frame();
  let open = false;
  for (let i = begin; i < end; i += 1) {
    const [x, y] = chart.place(xs[i], ys[i]);
    // Browsers do not dash what reaches far beyond the picture.
    if (!Number.isFinite(x + y) || Math.abs(y - top) > 3 * height) open = false;
    else if (open) path.lineTo(x, y);
    else {
      path.moveTo(x, y);
      open = true;
    }
  }
}

/**
 * Draw the trials of an experiment.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {Trials} trials
 * @param {number} ratio
 */
export function drawTrials(chart, context, { xs, ys, kinds }, ratio) {
  for (let i = 0; i < xs.length; i += 1) {
    const [x, y] = chart.place(xs[i], ys[i]);
    const name = CLASSES[kinds[i]];
    drawSign(context, SIGNS[name], x, y, ratio, colour(`trial-${name}`, chart.canvas));
  }
}

/**
 * Draw the cross at these values.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number]} cross
 * @param {number} ratio
 */
export function drawCross(chart, context, cross, ratio) {
  const [x, y] = chart.place(...cross);
  const path = new Path2D();
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    path.moveTo(x + 4 * dx * ratio, y + 4 * dy * ratio);
    path.lineTo(x + 13 * dx * ratio, y + 13 * dy * ratio);
  }
  outline(context, path, ["#000000", 4 * ratio], ["#ffffff", 2 * ratio]);
}

/**
 * Draw a sign about its middle.
 * @param {CanvasRenderingContext2D} context
 * @param {string} sign
 * @param {number} x
 * @param {number} y
 * @param {number} ratio
 * @param {string} paint
 */
function drawSign(context, sign, x, y, ratio, paint) {
  context.font = `${SIGN * ratio}px system-ui, sans-serif`;
  context.textAlign = "center";
  const { actualBoundingBoxAscent: above, actualBoundingBoxDescent: below } = context.measureText(sign);
  const base = y + 0.5 * (above - below);
  context.lineJoin = "round";
  for (const [ink, width] of /** @type {const} */ ([[DARK, 4], [LIGHT, 2.4]])) {
    context.strokeStyle = ink;
    context.lineWidth = width * ratio;
    context.strokeText(sign, x, base);
  }
  context.fillStyle = paint;
  context.fillText(sign, x, base);
}
