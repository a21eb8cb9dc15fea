/**
 * What a ball hangs on: a rod, a string that is taut, or one that is slack and hangs in an arc; and the
 * angle of a ball that is led, drawn from the vertical and written beside it.
 */

import { t } from "../strings.js";
import { line, place } from "./canvas.js";
import { short } from "../page/unit_text.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./canvas.js").Drawing} Drawing */
/**
 * A pose in which one ball is led: its number, and the text that stands beside it.
 * @typedef {import("./motion.js").Pose & {led: number, text: string}} LedBall
 */

// Strings are drawn this wide, and rods, in lengths of the longest one, and at least so wide.
const WIDTHS = { string: [0.006, 1.1], rod: [0.012, 1.5] };
// Halvings until the arc is as long as the string.
const HALVINGS = 40;
// A string is slack from this share of its length on.
const SPARE = 1e-6;
// Of the arc, and of the vertical below the pivot, in lengths of the ball's rod.
const ARC = 0.35;
const VERTICAL = 0.5;
const TEXT = 15; // pixels of the page
const GAP = 8;

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
 * @param {Drawing} drawing
 * @param {import("./motion.js").Pose} pose
 * @param {{isString: boolean, longest: number}} motion
 */
export function drawHangers(drawing, pose, { isString, longest }) {
  const { context, scale, colours } = drawing;
  const [share, least] = WIDTHS[isString ? "string" : "rod"];
  context.strokeStyle = isString ? colours.soft : colours.ink;
  context.lineWidth = Math.max(least * scale.ratio, share * longest * scale.size);
  drawLines(drawing, pose);
}

/**
 * Draw lines from the pivot to the balls, slack ones in an arc.
 * @param {Drawing} drawing
 * @param {import("./motion.js").Pose} pose
 */
export function drawLines({ context, scale }, { across, height, balls }) {
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

/**
 * Draw the angle of the ball that is led, and write it.
 * @param {Drawing} drawing
 * @param {LedBall} held
 * @param {Motion} motion
 */
export function drawAngle({ context, scale, colours }, { across, height, balls, led, text }, motion) {
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
