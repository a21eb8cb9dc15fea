/**
 * What stays on the stage for a moment: the trail of each ball, where it was, and a flash where two balls
 * touch, the larger the faster they met.
 */

import { isCalm } from "../page/dom.js";
import { line, place } from "./canvas.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./canvas.js").Scale} Scale */
/** @typedef {{x: number, y: number, strength: number, since: number, ring?: number}} Flash */

// How far back a trail goes, in natural periods, and in how many steps.
const SPAN = 1 / 3;
const STEPS = 48;
// Bands on top of each other, each of a newer part, make it fade.
const BANDS = 6;
const OPACITY = 0.1; // of one band
// Of a band where the ball is, in diameters of the ball; it begins with nothing.
const WIDTH = 0.6;
// Where the cosine of a turn is less, as at a clack, the corner of a band is round.
const SHARP = 0.9;
// Of a flash.
const DURATION = 260; // ms
// Balls that meet this fast make the largest flash, in natural angular frequencies: a toy that is
// shaken well reaches it.
const HARDEST = 6;
// Radius of the weakest and of the strongest one, in lengths of the longest rod.
const LEAST = 0.07;
const MOST = 0.3;
const RAYS = 10;

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

/**
 * Return how strong a clack is, from 0 to 1.
 * @param {number} speed at which the balls meet [rad/s]
 * @param {number} naturalFrequency [rad/s]
 */
export function strengthOf(speed, naturalFrequency) {
  return Math.min(Math.abs(speed) / (HARDEST * naturalFrequency), 1);
}

/**
 * The point of contact of two balls, on the line of their centres, divided in the ratio of their radii.
 * @param {{ball: import("./motion.js").MotionBall, x: number, y: number}[]} balls
 * @param {(ball: import("./motion.js").MotionBall) => number} radius
 */
export function contactPoint([one, other], radius) {
  const share = radius(one.ball) / (radius(one.ball) + radius(other.ball));
  return { x: one.x + share * (other.x - one.x), y: one.y + share * (other.y - one.y) };
}

/** The flashes on show; for whoever wants little motion nothing flashes. */
export class Flashes {
  constructor() {
    /** @type {Flash[]} */
    this.flashes = [];
  }

  /**
   * @param {{x: number, y: number}} point in m
   * @param {number} strength from 0 to 1
   */
  add(point, strength) {
    // A run that ended early has contacts where it has no samples.
    if (!isCalm() && Number.isFinite(point.x + point.y))
      this.flashes.push({ ...point, strength, since: performance.now() });
  }

  /**
   * Ring a ball whose string goes slack or taut.
   * @param {{x: number, y: number}} point in m
   * @param {number} ring radius of the ball [m]
   */
  ring(point, ring) {
    if (!isCalm()) this.flashes.push({ ...point, strength: 0, ring, since: performance.now() });
  }

  /**
   * Draw all that still shine; returns whether there are any.
   * @param {CanvasRenderingContext2D} context
   * @param {Scale} scale
   * @param {number} unit longest rod in pixels
   * @param {string} paint
   */
  draw(context, scale, unit, paint) {
    const now = performance.now();
    this.flashes = this.flashes.filter(({ since }) => now - since < DURATION);
    for (const { x, y, strength, since, ring } of this.flashes) {
      const age = (now - since) / DURATION;
      if (ring !== undefined) {
        drawRing(context, place(scale, x, y), ring * scale.size, age, paint);
        continue;
      }
      const radius = unit * (LEAST + (MOST - LEAST) * Math.sqrt(strength));
      drawFlash(context, place(scale, x, y), radius, age, paint);
    }
    return this.flashes.length > 0;
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number]} point
 * @param {number} radius of the ball
 * @param {number} age from 0 to 1
 * @param {string} paint
 */
function drawRing(context, [x, y], radius, age, paint) {
  context.globalAlpha = 1 - age;
  context.strokeStyle = paint;
  context.lineWidth = 0.16 * radius;
  context.beginPath();
  context.arc(x, y, radius * (1.15 + 0.35 * age), 0, 2 * Math.PI);
  context.stroke();
  context.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number]} point
 * @param {number} radius
 * @param {number} age from 0 to 1
 * @param {string} paint
 */
function drawFlash(context, [x, y], radius, age, paint) {
  const left = (1 - age) ** 2;
  const grown = radius * (0.45 + 0.55 * Math.sqrt(age));
  context.globalAlpha = left;
  const glow = context.createRadialGradient(x, y, 0, x, y, grown);
  glow.addColorStop(0, "#fff");
  glow.addColorStop(0.25, paint);
  glow.addColorStop(1, `${paint}00`);
  context.fillStyle = glow;
  context.beginPath();
  context.arc(x, y, grown, 0, 2 * Math.PI);
  context.fill();
  context.strokeStyle = paint;
  context.lineWidth = 0.07 * radius;
  for (let k = 0; k < RAYS; k += 1) {
    const turn = ((k + 0.5) * 2 * Math.PI) / RAYS;
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    // Every second ray is shorter.
    const end = grown * (k % 2 ? 0.85 : 1.1);
    line(context, x + 0.6 * grown * c, y + 0.6 * grown * s, x + end * c, y + end * s);
  }
  context.globalAlpha = 1;
}
