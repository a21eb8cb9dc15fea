/** The axes of a map and of its colour bar: frame, numbers and names with units. */

import { logTicks, ticks } from "../player/axis.js";
import { colour } from "../page/dom.js";
import { plainSymbol, localShort, shownUnit } from "../page/unit_text.js";

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {{low: number, high: number, log?: boolean}} Ends of an axis, and whether it is logarithmic */

/** Room for the numbers to the left of a map, in pixels of the page. */
export const MARGIN = 62;

/**
 * Return the name of an axis with its symbol and unit.
 * @param {{label: string, symbol: string, unit: string,
 *   units: {name: string, size: number}[]}} axis
 */
export function axisLabel(axis) {
  const symbol = plainSymbol(axis.symbol);
  const unit = shownUnit(axis.units[0]?.name ?? axis.unit);
  return `${axis.label}${symbol ? ` ${symbol}` : ""}${unit ? ` [${unit}]` : ""}`;
}

/**
 * Return how many SI units the shown unit is.
 * @param {{units: {name: string, size: number}[]}} axis
 */
export function sizeOf(axis) {
  return axis.units[0]?.size ?? 1;
}

/**
 * Return the share of an axis that lies before a value.
 * @param {Ends} ends
 * @param {number} value
 */
export function shareOf({ low, high, log }, value) {
  if (log) return Math.log(value / low) / Math.log(high / low);
  return (value - low) / (high - low);
}

/**
 * Draw the frame, ticks with numbers, and what the axes are, with units.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {number} ratio
 */
export function drawAxes(chart, context, ratio) {
  const { x, y } = /** @type {Grid} */ (chart.grid);
  const { left, top, width, height } = chart.frame();
  const corner = { x: left, y: top + height };
  drawTicks(context, { ...corner, length: width }, endsInUnit(chart.ends("x"), x), ratio);
  drawTicks(context, { ...corner, length: height, isUpright: true }, endsInUnit(chart.ends("y"), y), ratio);
  context.strokeRect(left - 0.5, top - 0.5, width + 1, height + 1);
  context.fillStyle = colour("ink", chart.canvas);
  context.textAlign = "center";
  context.textBaseline = "bottom";
  // A name that is too long is written narrower.
  context.fillText(axisLabel(x), left + width / 2, chart.canvas.height - 2 * ratio, width + MARGIN * ratio);
  context.save();
  context.translate(2 * ratio, top + height / 2);
  context.rotate(-Math.PI / 2);
  context.textBaseline = "top";
  context.fillText(axisLabel(y), 0, 0, height);
  context.restore();
}

/**
 * Return the ends of an axis in the unit shown.
 * @param {[number, number]} ends
 * @param {Grid["x"]} axis
 * @returns {Ends}
 */
function endsInUnit([low, high], axis) {
  const size = sizeOf(axis);
  return { low: low / size, high: high / size, log: axis.log };
}

/**
 * Draw the ticks of an axis, below its line or to the left of it, with their numbers.
 * @param {CanvasRenderingContext2D} context
 * @param {{x: number, y: number, length: number, isUpright?: boolean}} line where it begins and how
 *   long it is, in pixels
 * @param {Ends} ends
 * @param {number} ratio
 */
export function drawTicks(context, { x, y, length, isUpright = false }, ends, ratio) {
  const { low, high, log } = ends;
  const count = Math.max(2, length / ((isUpright ? 50 : 75) * ratio));
  const { marks, small } = log ? logTicks(low, high, count) : { marks: ticks(low, high, count), small: [] };
  const draw = (/** @type {number} */ value, /** @type {number} */ size, text = "") => {
    const along = shareOf(ends, value) * length;
    const [across, down] = isUpright ? [x, y - along] : [x + along, y];
    const [aside, below] = isUpright ? [-ratio, 0] : [0, ratio];
    context.moveTo(across, down);
    context.lineTo(across + size * aside, down + size * below);
    context.fillText(text, across + 7 * aside, down + 6 * below);
  };
  context.font = `${12 * ratio}px system-ui, sans-serif`;
  context.fillStyle = context.strokeStyle = colour("soft", context.canvas);
  context.lineWidth = ratio;
  [context.textAlign, context.textBaseline] = isUpright ? ["right", "middle"] : ["center", "top"];
  context.beginPath();
  for (const value of small) draw(value, 2.5);
  for (const value of marks) draw(value, 4, localShort(value, 5));
  context.stroke();
}
