/** Clacks that are seen: a flash where two balls touch, the larger the faster they met. */

import { place } from "./scale.js";
import { line } from "./strokes.js";

/** @typedef {import("./scale.js").Scale} Scale */
/** @typedef {{x: number, y: number, strength: number, since: number, ring?: number}} Flash */

const DURATION = 260; // ms
// Balls that meet this fast make the largest flash, in natural angular frequencies: a toy that is
// shaken well reaches it.
const HARDEST = 6;
// Radius of the weakest and of the strongest one, in lengths of the longest rod.
const LEAST = 0.07;
const MOST = 0.3;
const RAYS = 10;

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

/** The flashes on show. */
export class Flashes {
  constructor() {
    /** @type {Flash[]} */
    this.flashes = [];
    // For whoever wants little motion nothing flashes.
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
  }

  /**
   * @param {{x: number, y: number}} point in m
   * @param {number} strength from 0 to 1
   */
  add(point, strength) {
    // A run that ended early has contacts where it has no samples.
    if (!this.calm.matches && Number.isFinite(point.x + point.y))
      this.flashes.push({ ...point, strength, since: performance.now() });
  }

  /**
   * Ring a ball whose string goes slack or taut.
   * @param {{x: number, y: number}} point in m
   * @param {number} ring radius of the ball [m]
   */
  ring(point, ring) {
    if (!this.calm.matches) this.flashes.push({ ...point, strength: 0, ring, since: performance.now() });
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
