/** What lies over the cells of a map: curves, trials and the cross. */

import { colour } from "../page/dom.js";
import { outline } from "../player/canvas.js";

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {import("./chart.js").Trials} Trials */

const MARK = 5.5;
// A curve of bifurcations has its colour on white on black: one of them shows on any cells.
const DARK = "#1f2430";
const LIGHT = "#ffffff";
// Corners of the marks of special points by matplotlib's names of them; others are dots.
/** @type {Record<string, number[][]>} */
const CORNERS = {
  v: [[0, 1], [-1, -0.8], [1, -0.8]], "^": [[0, -1], [1, 0.8], [-1, 0.8]],
  s: [[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]], D: [[0, -1.2], [1.2, 0], [0, 1.2], [-1.2, 0]],
  p: [[0, -1.1], [1.05, -0.34], [0.65, 0.89], [-0.65, 0.89], [-1.05, -0.34]],
  X: [[-1, -0.5], [-0.5, -1], [0, -0.5], [0.5, -1], [1, -0.5], [0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5],
    [-0.5, 1], [-1, 0.5], [-0.5, 0]],
};

/**
 * Draw a line that shows on dark and on light cells: solid where stable motions end, dashed elsewhere, with
 * its special points.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {import("./curves.js").Line} line
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
    const path = new Path2D();
    if (!CORNERS[mark]) path.arc(left, top, MARK * ratio, 0, 2 * Math.PI);
    CORNERS[mark]?.forEach(([dx, dy], i) =>
      path[i ? "lineTo" : "moveTo"](left + dx * MARK * ratio, top + dy * MARK * ratio));
    path.closePath();
    outline(context, path, [DARK, 4 * ratio], [LIGHT, 2.6 * ratio]);
    context.fillStyle = paint;
    context.fill(path);
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
  const path = new Path2D();
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    path.moveTo(x + 4 * dx * ratio, y + 4 * dy * ratio);
    path.lineTo(x + 13 * dx * ratio, y + 13 * dy * ratio);
  }
  outline(context, path, ["#000000", 4 * ratio], ["#ffffff", 2 * ratio]);
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
  const path = new Path2D();
  if (kind === 0) path.arc(x, y, size, 0, 2 * Math.PI);
  else {
    const corners = kind === 1 ? [[0, -1.2], [1.1, 0.8], [-1.1, 0.8]]
      : [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]];
    corners.forEach(([dx, dy], i) =>
      path[i ? "lineTo" : "moveTo"](x + dx * size, y + dy * size));
    path.closePath();
  }
  context.fillStyle = paint;
  context.fill(path);
  outline(context, path, ["#ffffff", size / 2.6], ["#000000", size / 6]);
}
