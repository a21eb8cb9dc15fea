/** The angle of a ball that is led, drawn from the vertical and written beside it. */

import { line, place } from "./canvas.js";

/** @typedef {import("./motion.js").Motion} Motion */
/**
 * A pose in which one ball is led: its number, and the text that stands beside it.
 * @typedef {import("./motion.js").Pose & {led: number, text: string}} LedBall
 */

// Of the arc, and of the vertical below the pivot, in lengths of the ball's rod.
const ARC = 0.35;
const VERTICAL = 0.5;
const TEXT = 15; // pixels of the page
const GAP = 8;

/**
 * Draw the angle of the ball that is led, and write it.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./canvas.js").Scale} scale
 * @param {LedBall} held
 * @param {Motion} motion
 * @param {Record<string, string>} colours
 */
export function drawAngle(context, scale, { across, height, balls, led, text }, motion, colours) {
  const { ball, angle, x, y } = balls[led];
  const { size, ratio } = scale;
  const [px, py] = place(scale, across, height);
  const length = ball.length * size;
  context.strokeStyle = colours.soft;
  context.lineWidth = 1.2 * ratio;
  context.setLineDash([4 * ratio, 4 * ratio]);
  line(context, px, py, px, py + VERTICAL * length);
  context.setLineDash([]);
  context.beginPath();
  context.arc(px, py, ARC * length, Math.PI / 2, Math.PI / 2 - angle, angle > 0);
  context.stroke();
  context.font = `600 ${TEXT * ratio}px system-ui, sans-serif`;
  const { width } = context.measureText(text);
  const [bx, by] = place(scale, x, y);
  const gap = motion.radius(ball) * size + GAP * ratio;
  // On the outer side, unless the canvas ends there.
  const out = x < across ? bx - gap - width : bx + gap;
  const ends = context.canvas.width;
  const left = Math.min(Math.max(out, 2 * ratio), ends - width - 2 * ratio);
  const isBeside = left === out;
  context.textBaseline = "middle";
  context.textAlign = "left";
  context.lineWidth = 4 * ratio;
  context.strokeStyle = colours.card;
  context.fillStyle = colours.ink;
  const row = isBeside ? by : by - gap - 0.5 * TEXT * ratio;
  context.strokeText(text, left, row);
  context.fillText(text, left, row);
}
