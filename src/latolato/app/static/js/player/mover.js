/** What moves the pivot: the way that it goes, a crank, or the wheel that a cosine is made with. */

import { place } from "./scale.js";
import { line } from "./strokes.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./scale.js").Scale} Scale */

// Between the wheel and the pivot, in lengths of the longest rod.
const GAP = 0.2;
// Of the polygon that is drawn for an ellipse.
const CORNERS = 72;

/**
 * Return whether a wheel explains a run's drive: a point that goes round it is level with the pivot.
 * @param {Motion} motion
 */
export function drawsWheel({ about, pivotRange: [low, high] }) {
  return high > low && about.is_sinusoidal;
}

/**
 * Return whether a crank moves the pivot.
 * @param {Motion} motion
 */
export const drawsCrank = ({ about: { options } }) => options.drive === "crank_slider";

/**
 * Return the box that holds a crank or a wheel, null without one [m].
 * @param {Motion} motion
 * @param {boolean} withWheel
 */
export function moverBox(motion, withWheel) {
  const { about: { options }, pivotRange: [low, high], longest } = motion;
  if (drawsCrank(motion)) {
    const [, y] = crank(options, 0).center;
    const a = options.drive_amplitude;
    return { left: -a, right: a, low: y - a, high: y + a };
  }
  return withWheel && drawsWheel(motion)
    ? { left: -GAP * longest - (high - low), right: 0, low, high } : null;
}

/**
 * Draw what moves the pivot.
 * @param {CanvasRenderingContext2D} context
 * @param {Scale} scale
 * @param {Motion} motion
 * @param {number} time
 * @param {Record<string, string>} colours
 * @param {boolean} withWheel
 */
export function drawMover(context, scale, motion, time, colours, withWheel) {
  const { about: { options }, pivotRange: [low, high], longest } = motion;
  const unit = longest * scale.size;
  const { height } = motion.pose(time);
  context.strokeStyle = colours.line;
  context.lineWidth = Math.max(4 * scale.ratio, 0.03 * unit);
  if (options.drive === "planar_harmonic") drawEllipse(context, scale, options);
  else line(context, ...place(scale, 0, low), ...place(scale, 0, high));
  context.lineWidth = Math.max(scale.ratio, 0.008 * unit);
  if (drawsCrank(motion)) {
    const { center, pin } = crank(options, time);
    drawWheel(context, scale, center, pin, unit, colours.soft);
    line(context, ...place(scale, ...pin), ...place(scale, 0, height));
    return;
  }
  if (!withWheel || !drawsWheel(motion)) return;
  const radius = 0.5 * (high - low);
  const middle = 0.5 * (high + low);
  const away = -GAP * longest - radius;
  const up = height - middle;
  const across = Math.sqrt(Math.max(radius * radius - up * up, 0))
    * (motion.at("pivot_velocity", time) > 0 ? -1 : 1);
  drawWheel(context, scale, [away, middle], [away + across, height], unit, colours.soft);
  line(context, ...place(scale, away + across, height), ...place(scale, 0, height));
}

/**
 * Draw the way of a pivot that moves on an ellipse.
 * @param {CanvasRenderingContext2D} context
 * @param {Scale} scale
 * @param {any} options
 */
function drawEllipse(context, scale, { horizontal_amplitude: a, vertical_amplitude: b,
  horizontal_phase: lead = 0, vertical_phase: phase = 0 }) {
  context.beginPath();
  for (let k = 0; k <= CORNERS; k += 1) {
    const turn = (2 * Math.PI * k) / CORNERS;
    context.lineTo(...place(scale, a * Math.cos(turn + lead), b * Math.cos(turn + phase)));
  }
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Scale} scale
 * @param {[number, number]} center in m
 * @param {[number, number]} pin
 * @param {number} unit longest rod in pixels
 * @param {string} paint
 */
function drawWheel(context, scale, center, pin, unit, paint) {
  const radius = Math.hypot(pin[0] - center[0], pin[1] - center[1]) * scale.size;
  context.beginPath();
  context.arc(...place(scale, ...center), radius, 0, 2 * Math.PI);
  context.stroke();
  context.beginPath();
  context.arc(...place(scale, ...pin), Math.max(2 * scale.ratio, 0.014 * unit), 0, 2 * Math.PI);
  context.fillStyle = paint;
  context.fill();
}

/**
 * Return the centre of a crank and its pin at an instant [m]; a guide below has the crank above.
 * @param {any} options
 * @param {number} time
 * @returns {{center: [number, number], pin: [number, number]}}
 */
export function crank(options, time) {
  const phase = options.drive_frequency * time + (options.drive_phase ?? 0);
  const y = (options.guide === "above" ? -1 : 1) * options.connecting_rod_length;
  const a = options.drive_amplitude;
  return { center: [0, y], pin: [a * Math.sin(phase), y + a * Math.cos(phase)] };
}
