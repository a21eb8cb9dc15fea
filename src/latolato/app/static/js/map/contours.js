/** Contour lines over a map, with their values on them. */

import { before } from "../player/motion.js";
import { outline } from "../player/canvas.js";

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {{level: number, text: string, xs: Float64Array, ys: Float64Array}} Contour */

const INK = "#14171d";
const HALO = "#ffffff";
const FONT = 11.5; // pixels of the page
// A line shorter than its value and this much more bears none.
const ROOM = 36;
// Where along a line its value may stand, the best place first.
const PLACES = [0.5, 0.35, 0.65, 0.2, 0.8, 0.08, 0.92];

/**
 * Draw contour lines; returns what draws their values, over whatever else crosses them.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {Contour[]} contours
 * @param {number} ratio
 */
export function drawContours(chart, context, contours, ratio) {
  const lines = contours.map((each) => ({ text: each.text, points: cornersOf(chart, each) }));
  const path = new Path2D();
  for (const { points } of lines)
    for (let i = 0; i < points.length; i += 2)
      path[i ? "lineTo" : "moveTo"](points[i], points[i + 1]);
  context.lineJoin = "round";
  context.globalAlpha = 0.6;
  outline(context, path, [HALO, 2.8 * ratio]);
  context.globalAlpha = 1;
  outline(context, path, [INK, 1.2 * ratio]);
  return () => drawValues(chart, context, lines, ratio);
}

/**
 * Return the corners of a line on the canvas, x and y by turns.
 * @param {MapChart} chart
 * @param {Contour} contour
 */
function cornersOf(chart, { xs, ys }) {
  const points = new Float64Array(2 * xs.length);
  for (let i = 0; i < xs.length; i += 1) {
    const [x, y] = chart.place(xs[i], ys[i]);
    points[2 * i] = x;
    points[2 * i + 1] = y;
  }
  return points;
}

/**
 * Draw the value of each line that has room for it, long lines first, none over another.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {{text: string, points: Float64Array}[]} lines
 * @param {number} ratio
 */
function drawValues(chart, context, lines, ratio) {
  context.font = `600 ${FONT * ratio}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  /** @type {{x: number, y: number, half: number}[]} */
  const taken = [];
  const { left, top, width, height } = chart.frame();
  const measured = lines.map((line) => ({ ...line, along: lengths(line.points) }))
    .sort((a, b) => (b.along.at(-1) ?? 0) - (a.along.at(-1) ?? 0));
  for (const { text, points, along } of measured) {
    const length = along.at(-1) ?? 0;
    const room = context.measureText(text).width;
    if (length < room + ROOM * ratio) continue;
    const half = 0.5 * room + 5 * ratio;
    const place = PLACES.map((share) => pointAt(points, along, share * length)).find(([x, y]) =>
      x > left + half && x < left + width - half && y > top + half && y < top + height - half
      && taken.every((other) => Math.hypot(other.x - x, other.y - y) > half + other.half));
    if (!place) continue;
    const [x, y] = place;
    taken.push({ x, y, half });
    context.strokeStyle = HALO;
    context.lineWidth = 4 * ratio;
    context.strokeText(text, x, y);
    context.fillStyle = INK;
    context.fillText(text, x, y);
  }
}

/**
 * Return how far each corner lies along a line.
 * @param {Float64Array} points
 */
function lengths(points) {
  const along = new Float64Array(points.length / 2);
  for (let i = 1; i < along.length; i += 1)
    along[i] = along[i - 1]
      + Math.hypot(points[2 * i] - points[2 * i - 2], points[2 * i + 1] - points[2 * i - 1]);
  return along;
}

/**
 * Return the point of a line so far along it.
 * @param {Float64Array} points
 * @param {Float64Array} along
 * @param {number} distance
 */
function pointAt(points, along, distance) {
  const i = Math.min(before(along, distance), along.length - 2);
  const share = (distance - along[i]) / (along[i + 1] - along[i] || 1);
  return [0, 1].map((k) => points[2 * i + k] + share * (points[2 * i + 2 + k] - points[2 * i + k]));
}
