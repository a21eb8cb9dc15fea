/** The axes of a map: frame, numbers and names with units. */

import { ticks } from "../shared/axis.js";
import { colour } from "../shared/dom.js";
import { plainSymbol, localShort, shownUnit } from "../shared/units.js";
import { t } from "../strings.js";

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {import("./grid.js").Grid} Grid */

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
 * Draw the frame, ticks with numbers, and what the axes are, with units.
 * @param {MapChart} chart
 * @param {CanvasRenderingContext2D} context
 * @param {number} ratio
 */
export function drawAxes(chart, context, ratio) {
  const grid = /** @type {Grid} */ (chart.grid);
  const { left, top, width, height } = chart.frame();
  context.font = `${12 * ratio}px system-ui, sans-serif`;
  context.fillStyle = context.strokeStyle = colour("soft", chart.canvas);
  context.lineWidth = ratio;
  context.strokeRect(left - 0.5, top - 0.5, width + 1, height + 1);
  for (const which of /** @type {("x" | "y")[]} */ (["x", "y"])) {
    const axis = which === "x" ? grid.xAxis : grid.yAxis;
    const size = sizeOf(axis);
    const [low, high] = chart.ends(which);
    const length = which === "x" ? width : height;
    const many = Math.max(2, length / ((which === "x" ? 75 : 50) * ratio));
    const even = axis.log && low > 0 ? decades(low / size, high / size) : [];
    const marks = even.length > 1 ? even : ticks(low / size, high / size, many);
    context.beginPath();
    for (const mark of even.length > 1 ? tenths(low / size, high / size) : []) {
      const share = chart.share(which, mark * size);
      const [x, y] = which === "x" ? [left + share * width, top + height]
        : [left, top + (1 - share) * height];
      context.moveTo(x, y);
      if (which === "x") context.lineTo(x, y + 2.5 * ratio);
      else context.lineTo(x - 2.5 * ratio, y);
    }
    for (const mark of marks) {
      const share = chart.share(which, mark * size);
      if (share < -1e-9 || share > 1 + 1e-9) continue;
      if (which === "x") {
        const x = left + share * width;
        context.moveTo(x, top + height);
        context.lineTo(x, top + height + 4 * ratio);
        context.textAlign = "center";
        context.textBaseline = "top";
        context.fillText(localShort(mark, 5), x, top + height + 6 * ratio);
      } else {
        const y = top + (1 - share) * height;
        context.moveTo(left - 4 * ratio, y);
        context.lineTo(left, y);
        context.textAlign = "right";
        context.textBaseline = "middle";
        context.fillText(localShort(mark, 5), left - 7 * ratio, y);
      }
    }
    context.stroke();
  }
  context.fillStyle = colour("ink", chart.canvas);
  context.textAlign = "center";
  context.textBaseline = "bottom";
  context.fillText(fitted(context, axisLabel(grid.xAxis), width + MARGIN * ratio),
    left + width / 2, chart.canvas.height - 2 * ratio);
  context.save();
  context.translate(2 * ratio, top + height / 2);
  context.rotate(-Math.PI / 2);
  context.textBaseline = "top";
  context.fillText(fitted(context, axisLabel(grid.yAxis), height), 0, 0);
  context.restore();
}

/**
 * Return the powers of ten between two values, and their halves and doubles where they are few.
 * @param {number} low
 * @param {number} high
 */
function decades(low, high) {
  const ticks = [];
  const few = high / low < 1000;
  for (let k = Math.floor(Math.log10(low)); k <= Math.log10(high); k += 1)
    for (const digit of few ? [1, 2, 5] : [1])
      if (digit * 10 ** k >= low && digit * 10 ** k <= high) ticks.push(digit * 10 ** k);
  return ticks;
}

/**
 * Return the whole multiples of powers of ten between two values, up to three decades.
 * @param {number} low
 * @param {number} high
 */
function tenths(low, high) {
  const ticks = [];
  if (high / low > 1e4) return [];
  for (let k = Math.floor(Math.log10(low)); k <= Math.log10(high); k += 1)
    for (let digit = 1; digit < 10; digit += 1)
      if (digit * 10 ** k >= low && digit * 10 ** k <= high) ticks.push(digit * 10 ** k);
  return ticks;
}

/**
 * Return a text, shortened with an ellipsis where it is wider than there is room.
 * @param {CanvasRenderingContext2D} context
 * @param {string} text
 * @param {number} room
 */
function fitted(context, text, room) {
  if (context.measureText(text).width <= room) return text;
  let end = text.length;
  while (end > 1 && context.measureText(`${text.slice(0, end)}…`).width > room) end -= 1;
  return t("cut", { text: text.slice(0, end) });
}
