/** What lies over the cells of a map: curves, trials and the cross. */

import { colour } from "../page/dom.js";
import { outline } from "../player/strokes.js";

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {import("./chart.js").ChartLine} ChartLine */
/** @typedef {import("./chart.js").Trials} Trials */

const MARK = 5.5;

/**
 * Draw a curve that shows on dark and on light cells.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {ChartLine} line
 * @param {number} ratio
 */
export function drawLine(chart, context, { xs, ys, dashed }, ratio) {
  const { top, height } = chart.frame();
  const path = new Path2D();
  let open = false;
  for (let i = 0; i < xs.length; i += 1) {
    const [x, y] = chart.place(xs[i], ys[i]);
    // Browsers do not dash what reaches far beyond the picture.
    if (!Number.isFinite(x + y) || Math.abs(y - top) > 3 * height) open = false;
    else if (open) path.lineTo(x, y);
    else {
      path.moveTo(x, y);
      open = true;
    }
  }
  outline(context, path, ["#1f2430", 3.6 * ratio],
    ["#ffffff", 1.8 * ratio, dashed ? [7 * ratio, 4 * ratio] : []]);
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
