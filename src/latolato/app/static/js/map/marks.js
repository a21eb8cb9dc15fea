/** What lies over the cells of a map: curves, trials and the cross. */

import { colour } from "../shared/dom.js";

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {import("./chart.js").Line} Line */
/** @typedef {import("./chart.js").Trials} Trials */

const MARK = 5.5;

/**
 * Draw a curve that shows on dark and on light cells.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {Line} line
 * @param {number} ratio
 */
export function drawLine(chart, context, { xs, ys, dashed }, ratio) {
  const { top, height } = chart.frame();
  context.beginPath();
  let open = false;
  for (let i = 0; i < xs.length; i += 1) {
    const [x, y] = chart.place(xs[i], ys[i]);
    // Browsers do not dash what reaches far beyond the picture.
    if (!Number.isFinite(x + y) || Math.abs(y - top) > 3 * height) open = false;
    else if (open) context.lineTo(x, y);
    else {
      context.moveTo(x, y);
      open = true;
    }
  }
  context.setLineDash([]);
  context.strokeStyle = "#1f2430";
  context.lineWidth = 3.6 * ratio;
  context.stroke();
  context.setLineDash(dashed ? [7 * ratio, 4 * ratio] : []);
  context.strokeStyle = "#ffffff";
  context.lineWidth = 1.8 * ratio;
  context.stroke();
  context.setLineDash([]);
}

/**
 * Draw the trials of an experiment.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {Trials} trials
 * @param {number} ratio
 */
export function drawTrials(chart, context, { xs, ys, kinds }, ratio) {
  const paints = ["trial-none", "trial-weak", "trial-strong"];
  for (let i = 0; i < xs.length; i += 1) {
    const [x, y] = chart.place(xs[i], ys[i]);
    drawMark(context, kinds[i], x, y, MARK * ratio, colour(paints[kinds[i]], chart.canvas));
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
  /** @type {[string, number][]} */
  const strokes = [["#000000", 4], ["#ffffff", 2]];
  for (const [paint, width] of strokes) {
    context.strokeStyle = paint;
    context.lineWidth = width * ratio;
    context.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      context.moveTo(x + 4 * dx * ratio, y + 4 * dy * ratio);
      context.lineTo(x + 13 * dx * ratio, y + 13 * dy * ratio);
    }
    context.stroke();
  }
}

/**
 * Draw the mark of a trial: a dot (none), a triangle (weak), a diamond (strong).
 * @param {CanvasRenderingContext2D} context
 * @param {number} kind
 * @param {number} x
 * @param {number} y
 * @param {number} size
 * @param {string} paint
 */
function drawMark(context, kind, x, y, size, paint) {
  context.beginPath();
  if (kind === 0) context.arc(x, y, size, 0, 2 * Math.PI);
  else {
    const corners = kind === 1 ? [[0, -1.2], [1.1, 0.8], [-1.1, 0.8]]
      : [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]];
    corners.forEach(([dx, dy], i) =>
      context[i ? "lineTo" : "moveTo"](x + dx * size, y + dy * size));
    context.closePath();
  }
  context.fillStyle = paint;
  context.fill();
  context.strokeStyle = "#ffffff";
  context.lineWidth = size / 2.6;
  context.stroke();
  context.strokeStyle = "#000000";
  context.lineWidth = size / 6;
  context.stroke();
}
