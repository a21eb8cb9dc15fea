/** The trail of each ball: where it was a moment ago. */

import { place } from "./scale.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./scale.js").Scale} Scale */

// How far back it goes, in natural periods, and in how many steps.
const SPAN = 1 / 3;
const STEPS = 48;
// Lines on top of each other, each of the newer part and broader, make it fade and taper.
const LINES = 6;
const OPACITY = 0.1; // of one line
// Of the broadest line, in diameters of the ball.
const WIDTH = 0.6;

/**
 * Draw the trails of all balls, fading towards the past.
 * @param {CanvasRenderingContext2D} context
 * @param {Scale} scale
 * @param {Motion} motion
 * @param {number} time
 * @param {Record<string, string>} colours
 */
export function drawTrails(context, scale, motion, time, colours) {
  const poses = motion.recent(time, (SPAN * 2 * Math.PI) / motion.naturalFrequency, STEPS);
  context.globalAlpha = OPACITY;
  motion.balls.forEach((ball, i) => {
    const points = poses.map(({ balls }) => place(scale, balls[i].x, balls[i].y));
    const width = WIDTH * 2 * motion.radius(ball) * scale.size;
    context.strokeStyle = ball.name === "left" ? colours.left : colours.right;
    for (let k = 1; k <= LINES; k += 1) {
      const first = Math.floor(((k - 1) / LINES) * (points.length - 1));
      context.lineWidth = Math.max((k / LINES) * width, 1.5 * scale.ratio);
      context.beginPath();
      for (const point of points.slice(first)) context.lineTo(...point);
      context.stroke();
    }
  });
  context.globalAlpha = 1;
}
