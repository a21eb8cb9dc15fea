/**
 * What is at the pivot: the hand that holds it, an arm that comes from the right and a fist seen from its
 * front; and what moves it: the way that it goes, a crank, or the wheel that a cosine is made with.
 */

import { line, place } from "./canvas.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {import("./canvas.js").Drawing} Drawing */

// Between the wheel and the pivot, in lengths of the longest rod.
const GAP = 0.2;
// Of the polygon that is drawn for an ellipse.
const CORNERS = 72;
// Half of the fist's width, in lengths of the longest rod.
const SIZE = 0.095;
// The fist stays inside of this share of the gap between the pivot and the balls that pass it.
const SHARE_OF_GAP = 0.6;
/** How far the hand reaches about the pivot, in halves of the fist's width. */
const REACH = { left: 1.2, right: 3, above: 1.6, below: 0.9 };
// The arm rises to the right [rad].
const RISE = 0.3;
const LINE = 0.1;
// Left edge, width, top and bottom of each finger.
const FINGERS = [
  [-1, 0.5, -0.66, 0.34], [-0.5, 0.52, -0.82, 0.42], [0.02, 0.5, -0.8, 0.4], [0.52, 0.44, -0.62, 0.3],
];

/**
 * Return half of the width of the fist [m]: no ball that passes the hand is hidden by it.
 * @param {{length: number, radius: number}[]} balls with the radius that is drawn
 */
export function fistSize(balls) {
  const gap = Math.min(...balls.map(({ length, radius }) => length - radius));
  return Math.min(SIZE * Math.max(...balls.map(({ length }) => length)), SHARE_OF_GAP * gap);
}

/**
 * Return the box that holds the hand about the pivot [m].
 * @param {number} size of the fist in m
 */
export function handBox(size) {
  return { left: -REACH.left * size, right: REACH.right * size, low: -REACH.below * size,
    high: REACH.above * size };
}

/**
 * Draw the arm, which belongs behind rods and balls.
 * @param {Drawing} drawing
 * @param {Pose} pose
 * @param {number} size of the fist in m
 */
export function drawArm(drawing, pose, size) {
  const { context, colours } = drawing;
  scaleToFist(drawing, pose, size);
  context.rotate(-RISE);
  block(context, 0.3, -0.52, 1.6, 1.04, 0.3);
  context.fillStyle = colours.sleeve;
  block(context, 1.6, -0.64, 1.1, 1.28, 0.16);
  block(context, 1.45, -0.7, 0.34, 1.4, 0.14);
  context.restore();
}

/**
 * Draw the fist, which holds the ends of the rods.
 * @param {Drawing} drawing
 * @param {Pose} pose
 * @param {number} size of the fist in m
 */
export function drawFist(drawing, pose, size) {
  const { context } = drawing;
  scaleToFist(drawing, pose, size);
  block(context, -0.98, -0.7, 1.94, 1.45, 0.5);
  for (const [left, width, top, bottom] of FINGERS)
    block(context, left, top, width, bottom - top, 0.22);
  // The thumb lies across them.
  context.translate(-0.25, 0.5);
  context.rotate(-0.12);
  block(context, -0.82, -0.24, 1.35, 0.48, 0.24);
  context.restore();
}

/**
 * Go to coordinates in which the fist is two wide; the caller restores the context.
 * @param {Drawing} drawing
 * @param {Pose} pose
 * @param {number} size
 */
function scaleToFist({ context, scale, colours }, { across, height }, size) {
  context.save();
  context.translate(...place(scale, across, height));
  context.scale(size * scale.size, size * scale.size);
  context.lineWidth = LINE;
  context.strokeStyle = colours["skin-line"];
  context.fillStyle = colours.skin;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} left
 * @param {number} top
 * @param {number} width
 * @param {number} height
 * @param {number} corner its radius
 */
function block(context, left, top, width, height, corner) {
  context.beginPath();
  context.roundRect(left, top, width, height, corner);
  context.fill();
  context.stroke();
}

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
 * @param {Drawing} drawing
 * @param {Motion} motion
 * @param {number} time
 * @param {boolean} withWheel
 */
export function drawMover(drawing, motion, time, withWheel) {
  const { context, scale, colours } = drawing;
  const { about: { options }, pivotRange: [low, high], longest } = motion;
  const unit = longest * scale.size;
  const { height } = motion.pose(time);
  context.strokeStyle = colours.line;
  context.lineWidth = Math.max(4 * scale.ratio, 0.03 * unit);
  if (options.drive === "planar_harmonic") drawEllipse(drawing, options);
  else line(context, ...place(scale, 0, low), ...place(scale, 0, high));
  context.lineWidth = Math.max(scale.ratio, 0.008 * unit);
  if (drawsCrank(motion)) {
    const { center, pin } = crank(options, time);
    drawWheel(drawing, center, pin, unit);
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
  drawWheel(drawing, [away, middle], [away + across, height], unit);
  line(context, ...place(scale, away + across, height), ...place(scale, 0, height));
}

/**
 * Draw the way of a pivot that moves on an ellipse.
 * @param {Drawing} drawing
 * @param {any} options
 */
function drawEllipse({ context, scale }, { horizontal_amplitude: a, vertical_amplitude: b,
  horizontal_phase: lead = 0, vertical_phase: phase = 0 }) {
  context.beginPath();
  for (let k = 0; k <= CORNERS; k += 1) {
    const turn = (2 * Math.PI * k) / CORNERS;
    context.lineTo(...place(scale, a * Math.cos(turn + lead), b * Math.cos(turn + phase)));
  }
  context.stroke();
}

/**
 * @param {Drawing} drawing
 * @param {[number, number]} center in m
 * @param {[number, number]} pin
 * @param {number} unit longest rod in pixels
 */
function drawWheel({ context, scale, colours }, center, pin, unit) {
  const radius = Math.hypot(pin[0] - center[0], pin[1] - center[1]) * scale.size;
  context.beginPath();
  context.arc(...place(scale, ...center), radius, 0, 2 * Math.PI);
  context.stroke();
  context.beginPath();
  context.arc(...place(scale, ...pin), Math.max(2 * scale.ratio, 0.014 * unit), 0, 2 * Math.PI);
  context.fillStyle = colours.soft;
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
