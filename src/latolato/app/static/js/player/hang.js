/** What a ball hangs on: a rod, a string that is taut, or one that is slack and hangs in an arc. */

import { t } from "../strings.js";
import { line, place } from "./canvas.js";
import { short } from "../page/unit_text.js";

/** @typedef {import("./canvas.js").Scale} Scale */

// Strings are drawn this wide, and rods, in lengths of the longest one, and at least so wide.
const WIDTHS = { string: [0.006, 1.1], rod: [0.012, 1.5] };
// Halvings until the arc is as long as the string.
const HALVINGS = 40;
// A string is slack from this share of its length on.
const SPARE = 1e-6;

/**
 * Return whether a ball at a distance hangs on a slack string.
 * @param {number} distance [m]
 * @param {number} length of its string [m]
 */
export const isSlack = (distance, length) => distance < length * (1 - SPARE);

/**
 * Return how far the balls on slack strings are from the hand, in words; mirrored ones are so alike.
 * @param {{isString: boolean, balls: import("./motion.js").MotionBall[],
 *   pose: (time: number) => import("./motion.js").Pose}} motion
 * @param {number} time
 */
export function slackText(motion, time) {
  if (!motion.isString) return "";
  const isPair = motion.balls.some(({ row }) => row > 0);
  return motion.pose(time).balls
    .filter(({ ball, distance }, i) => (i === 0 || ball.row > 0) && isSlack(distance, ball.length))
    .map(({ ball, distance }) => t(`slackText_${isPair ? ball.name : "ball"}`,
      { distance: short(100 * distance, 3) })).join("");
}

/**
 * Return how far below the middle of its chord a string hangs [m]: it is the arc of a parabola,
 * `t (across, rise) - (0, 4 sag t (1 - t))`, of its own length. `latolato.figures.animate` draws the same.
 * @param {number} across from end to end [m]
 * @param {number} rise
 * @param {number} length of the string [m]
 */
export function sagOf(across, rise, length) {
  const h = Math.max(Math.abs(across), 1e-9 * length);
  const area = (/** @type {number} */ u) => 0.5 * (u * Math.hypot(h, u) + h * h * Math.asinh(u / h));
  // The mean speed along the arc, whose upright part changes steadily.
  const arc = (/** @type {number} */ sag) => (area(rise + 4 * sag) - area(rise - 4 * sag)) / (8 * sag);
  let [low, high] = [0, 0.5 * length];
  for (let k = 0; k < HALVINGS; k += 1) {
    const middle = 0.5 * (low + high);
    if (arc(middle) < length) low = middle;
    else high = middle;
  }
  return low;
}

/**
 * Draw what the balls of a pose hang on.
 * @param {CanvasRenderingContext2D} context
 * @param {Scale} scale
 * @param {import("./motion.js").Pose} pose
 * @param {{isString: boolean, longest: number}} motion
 * @param {Record<string, string>} colours
 */
export function drawHangers(context, scale, pose, { isString, longest }, colours) {
  const [share, least] = WIDTHS[isString ? "string" : "rod"];
  context.strokeStyle = isString ? colours.soft : colours.ink;
  context.lineWidth = Math.max(least * scale.ratio, share * longest * scale.size);
  drawLines(context, scale, pose);
}

/**
 * Draw lines from the pivot to the balls, slack ones in an arc.
 * @param {CanvasRenderingContext2D} context
 * @param {Scale} scale
 * @param {import("./motion.js").Pose} pose
 */
export function drawLines(context, scale, { across, height, balls }) {
  const pivot = place(scale, across, height);
  for (const { ball, x, y, distance } of balls) {
    const [bx, by] = place(scale, x, y);
    if (!isSlack(distance, ball.length)) {
      line(context, ...pivot, bx, by);
      continue;
    }
    const sag = sagOf(x - across, y - height, ball.length);
    const control = place(scale, 0.5 * (across + x), 0.5 * (height + y) - 2 * sag);
    context.beginPath();
    context.moveTo(...pivot);
    context.quadraticCurveTo(...control, bx, by);
    context.stroke();
  }
}
