/**
 * What stays on the stage for a moment: the trail of each ball, where it was, and a flash where two balls
 * touch, the larger the faster they met.
 */

import { isCalm } from "../page/dom.js";
import { line, place } from "./canvas.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./canvas.js").Drawing} Drawing */
/** @typedef {{x: number, y: number, strength: number, since: number}} Flash */

// How far back a trail goes, in natural periods, and in how many steps.
const SPAN = 1 / 3;
const STEPS = 48;
// Lines on top of each other, each of a newer part and wider than the one before, make it fade and taper.
const LINES = 8;
const OPACITY = 0.08; // of one line
// Of the widest line, in diameters of the ball.
const WIDTH = 0.6;
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
 * @param {Drawing} drawing
 * @param {Motion} motion
 * @param {number} time
 */
export function drawTrails({ context, scale, colours }, motion, time) {
  const poses = motion.recent(time, (SPAN * 2 * Math.PI) / motion.naturalFrequency, STEPS);
  context.globalAlpha = OPACITY;
  motion.balls.forEach((ball, i) => {
    const points = poses.map(({ balls }) => place(scale, balls[i].x, balls[i].y));
    context.strokeStyle = ball.name === "left" ? colours.left : colours.right;
    for (let k = 0; k < LINES; k += 1) {
      context.lineWidth = ((k + 1) / LINES) * WIDTH * 2 * motion.radius(ball) * scale.size;
      context.beginPath();
      for (const point of points.slice(Math.floor((k / LINES) * (points.length - 1)))) context.lineTo(...point);
      context.stroke();
    }
  });
  context.globalAlpha = 1;
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
   * Draw all that still shine; returns whether there are any.
   * @param {Drawing} drawing
   * @param {number} unit longest rod in pixels
   */
  draw({ context, scale, colours }, unit) {
    const now = performance.now();
    this.flashes = this.flashes.filter(({ since }) => now - since < DURATION);
    for (const { x, y, strength, since } of this.flashes) {
      const radius = unit * (LEAST + (MOST - LEAST) * Math.sqrt(strength));
      drawFlash(context, place(scale, x, y), radius, (now - since) / DURATION, colours.flash);
    }
    return this.flashes.length > 0;
  }
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
