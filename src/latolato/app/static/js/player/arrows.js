/** Arrows at the balls, for their velocity and for the forces on them, and what they mean. */

import { t } from "../strings.js";
import { el } from "../page/dom.js";
import { drawsCrank, drawsWheel } from "./pivot.js";
import { line, place } from "./canvas.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./canvas.js").Drawing} Drawing */

// Lengths of arrows, in lengths of the longest rod: of the fastest ball of the run, of its weight,
// and the most that a force gets.
const FASTEST = 0.35;
const WEIGHT = 0.15;
const MOST = 0.8;
/** How far below a ball its weight reaches, in lengths of the longest rod. */
export const ROOM = WEIGHT;
const HEAD = 8; // pixels of the page
// A shorter arrow is not drawn.
const SHORTEST = 2;

/**
 * Return the velocity of a ball as it is seen [m/s], to the right and upwards: about the pivot, and
 * with it.
 * @param {number} distance from the pivot [m]
 * @param {number} angle as it is drawn [rad]
 * @param {number} rate of the angle as it is drawn [rad/s]
 * @param {number} pivotVelocity [m/s]
 * @param {{radial?: number, across?: number}} [more] velocity along the string, and that of the pivot
 *   to the right [m/s]
 * @returns {[number, number]}
 */
export function velocityOf(distance, angle, rate, pivotVelocity, { radial = 0, across = 0 } = {}) {
  const speed = distance * rate;
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  return [speed * c + radial * s + across, speed * s - radial * c + pivotVelocity];
}

/**
 * Return the greatest speed of a run's balls as it is seen [m/s].
 * @param {Motion} motion
 */
export function topSpeed(motion) {
  const pivot = motion.values("pivot_velocity");
  const aside = motion.values("pivot_across_velocity");
  let top = 1e-9;
  for (const ball of motion.balls) {
    const angles = motion.values("angle", ball.row);
    const rates = motion.values("angular_velocity", ball.row);
    const [distances, radial] = ["distance", "radial_velocity"].map((name) => motion.values(name, ball.row));
    if (!angles || !rates || !pivot) continue;
    for (let i = 0; i < angles.length; i += 1) {
      const speed = Math.hypot(...velocityOf(distances?.[i] ?? ball.length, angles[i], rates[i], pivot[i],
        { radial: radial?.[i], across: ball.sign * (aside?.[i] ?? 0) }));
      if (speed > top) top = speed;
    }
  }
  return top;
}

/**
 * Return the arrows at the balls at an instant, in m to the right and upwards: velocities, the
 * forces of the rods, which point to the pivot where a rod pulls and away where it pushes, and
 * weights.
 * @param {Motion} motion
 * @param {number} time
 * @param {number} fastest of its balls [m/s]
 */
export function arrowsAt(motion, time, fastest) {
  const { gravity } = motion.about.options;
  const unit = motion.longest;
  return motion.pose(time).balls.flatMap(({ ball, angle, distance, x, y }) => {
    const rate = ball.sign * motion.at("angular_velocity", time, ball.row);
    const [u, v] = velocityOf(distance, angle, rate, motion.at("pivot_velocity", time), {
      radial: motion.at("radial_velocity", time, ball.row) || 0,
      across: motion.at("pivot_across_velocity", time) || 0 });
    const scale = (FASTEST * unit) / fastest;
    const arrows = [{ paint: "speed", x, y, dx: scale * u, dy: scale * v },
      { paint: "soft", x, y, dx: 0, dy: -WEIGHT * unit }];
    const tension = motion.at("tension", time, ball.row);
    // The small-angle model has none.
    if (!Number.isFinite(tension)) return arrows;
    const weights = tension / (ball.mass * gravity);
    const length = unit * Math.min(Math.max(WEIGHT * weights, -MOST), MOST);
    arrows.push({ paint: "force", x, y, dx: -length * Math.sin(angle), dy: length * Math.cos(angle) });
    return arrows;
  });
}

/**
 * @param {Drawing} drawing
 * @param {ReturnType<typeof arrowsAt>} arrows
 */
export function drawArrows({ context, scale, colours }, arrows) {
  for (const { paint, x, y, dx, dy } of arrows)
    drawArrow(context, place(scale, x, y), scale.size * dx, -scale.size * dy, scale.ratio, colours[paint]);
}

/**
 * Draw an arrow, in pixels.
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number]} from
 * @param {number} dx
 * @param {number} dy
 * @param {number} ratio
 * @param {string} paint
 */
function drawArrow(context, [x, y], dx, dy, ratio, paint) {
  const length = Math.hypot(dx, dy);
  if (length < SHORTEST) return;
  const head = Math.min(HEAD * ratio, 0.5 * length);
  const [ux, uy] = [dx / length, dy / length];
  context.strokeStyle = context.fillStyle = paint;
  context.lineWidth = 2.5 * ratio;
  line(context, x, y, x + dx - ux * head, y + dy - uy * head);
  context.beginPath();
  context.moveTo(x + dx, y + dy);
  context.lineTo(x + dx - head * (ux - 0.5 * uy), y + dy - head * (uy + 0.5 * ux));
  context.lineTo(x + dx - head * (ux + 0.5 * uy), y + dy - head * (uy - 0.5 * ux));
  context.fill();
}

/**
 * The legend of a run's arrows, as items of a list.
 * @param {Motion} motion
 */
export function legendOf(motion) {
  const item = (/** @type {string} */ paint, /** @type {string} */ name) =>
    el("li", {}, el("span", { class: `key ${paint}` }), t(name));
  return [item("speed", "legendVelocity"), item("soft", "legendWeight"),
    motion.values("tension") && item("force", motion.isString ? "legendString" : "legendRod"),
    drawsWheel(motion) && item("wheel", "legendWheel"),
    drawsCrank(motion) && item("wheel", "legendCrank")].filter((each) => each instanceof Element);
}
