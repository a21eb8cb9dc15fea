/** The trail of each ball: where it was a moment ago. */

import { place } from "./scale.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./scale.js").Scale} Scale */

// How far back it goes, in natural periods, and in how many steps.
const SPAN = 1 / 3;
const STEPS = 48;
// Bands on top of each other, each of a newer part, make it fade.
const BANDS = 6;
const OPACITY = 0.1; // of one band
// Of a band where the ball is, in diameters of the ball; it begins with nothing.
const WIDTH = 0.6;
// Where the cosine of a turn is less, as at a clack, the corner of a band is round.
const SHARP = 0.9;

/**
 * Draw the trails of all balls, fading and tapering towards the past.
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
    context.fillStyle = ball.name === "left" ? colours.left : colours.right;
    for (let k = 0; k < BANDS; k += 1) {
      const part = points.slice(Math.floor((k / BANDS) * (points.length - 1)));
      fillBand(context, part, WIDTH * motion.radius(ball) * scale.size);
    }
  });
  context.globalAlpha = 1;
}

/**
 * Fill a band along points that grows from nothing.
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number][]} points
 * @param {number} half of its width at the end [pixels]
 */
function fillBand(context, points, half) {
  const along = points.filter(([x, y], i) => !i || x !== points[i - 1][0] || y !== points[i - 1][1]);
  const ways = along.slice(1).map(([x, y], i) => {
    const [u, v] = [x - along[i][0], y - along[i][1]];
    const length = Math.hypot(u, v);
    return [u / length, v / length];
  });
  const isSharp = (/** @type {number} */ i) => i > 0 && i < ways.length
    && ways[i - 1][0] * ways[i][0] + ways[i - 1][1] * ways[i][1] < SHARP;
  // Across the band at the end of a piece: pieces share their corners where the turn is slight.
  const across = (/** @type {number} */ i, /** @type {number} */ piece) => {
    const [one, other] = isSharp(i) ? [piece, piece] : [Math.max(i - 1, 0), Math.min(i, ways.length - 1)];
    const share = (0.5 * half * i) / ways.length;
    return [-share * (ways[one][1] + ways[other][1]), share * (ways[one][0] + ways[other][0])];
  };
  context.beginPath();
  let first = 0;
  for (let end = 1; end <= ways.length; end += 1) {
    if (end < ways.length && !isSharp(end)) continue;
    // Pieces that share their corners have one outline: there on one side, and back on the other.
    const edges = along.slice(first, end + 1).map(([x, y], k) => {
      const [a, b] = across(first + k, Math.min(first + k, end - 1));
      return { x, y, a, b };
    });
    const [{ x, y, a, b }] = edges;
    context.moveTo(x - a, y - b);
    for (const edge of edges) context.lineTo(edge.x - edge.a, edge.y - edge.b);
    for (const edge of edges.reverse()) context.lineTo(edge.x + edge.a, edge.y + edge.b);
    if (first) {
      const radius = Math.hypot(a, b);
      context.moveTo(x + radius, y);
      context.arc(x, y, radius, 0, 2 * Math.PI);
    }
    first = end;
  }
  context.fill();
}
