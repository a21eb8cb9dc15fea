/** Stretches of time behind curves, each in the colour of what it means. */

import { colour } from "../page/dom.js";

/** @typedef {{from: number, to: number, paint: string}} Shade */

const STRENGTH = 0.28;

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
