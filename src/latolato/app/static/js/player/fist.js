/** The hand that holds the pivot: an arm that comes from the right, and a fist seen from its front. */


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
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number]} pivot in pixels
 * @param {number} size of the fist in pixels
 * @param {Record<string, string>} colours
 */
export function drawArm(context, pivot, size, colours) {
  begin(context, pivot, size, colours);
  context.rotate(-RISE);
  block(context, 0.3, -0.52, 1.6, 1.04, 0.3);
  context.fillStyle = colours.sleeve;
  block(context, 1.6, -0.64, 1.1, 1.28, 0.16);
  block(context, 1.45, -0.7, 0.34, 1.4, 0.14);
  context.restore();
}

/**
 * Draw the fist, which holds the ends of the rods.
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number]} pivot in pixels
 * @param {number} size of the fist in pixels
 * @param {Record<string, string>} colours
 */
export function drawFist(context, pivot, size, colours) {
  begin(context, pivot, size, colours);
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
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number]} pivot
 * @param {number} size
 * @param {Record<string, string>} colours
 */
function begin(context, pivot, size, colours) {
  context.save();
  context.translate(...pivot);
  context.scale(size, size);
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
