/** Drawing on canvases: where the points of a scene lie, from metres to pixels, and lines. */

/** @typedef {{left: number, right: number, low: number, high: number}} Box in m */

/**
 * How many pixels a metre and a pixel of the page are, and where the origin lies, in pixels.
 * @typedef {{size: number, ratio: number, x: number, y: number}} Scale
 *
 * What the parts of a scene are drawn with; colours are those of the page, by their names.
 * @typedef {{context: CanvasRenderingContext2D, scale: Scale, colours: Record<string, string>}} Drawing
 */

// Around the box, as a share of it.
const MARGIN = 0.1;

/**
 * Return the scale that shows a box as large as it fits, its origin in the middle where there is
 * room for that.
 * @param {Box} box
 * @param {number} width in pixels
 * @param {number} height
 * @param {number} ratio
 * @returns {Scale}
 */
export function fitScale({ left, right, low, high }, width, height, ratio) {
  const grown = 1 + MARGIN;
  const size = Math.min(width / ((right - left) * grown || 1), height / ((high - low) * grown || 1));
  const spare = 0.5 * (width - (right - left) * size);
  // The box moves by no more than the room beside it, less its margin.
  const room = Math.max(spare - 0.5 * MARGIN * (right - left) * size, 0);
  const off = 0.5 * (left + right) * size;
  const x = 0.5 * width - off + Math.min(Math.max(off, -room), room);
  return { size, ratio, x, y: 0.5 * height + 0.5 * (low + high) * size };
}

/**
 * The position of a point, in pixels.
 * @param {Scale} scale
 * @param {number} x in m to the right
 * @param {number} y in m upwards
 * @returns {[number, number]}
 */
export function place(scale, x, y) {
  return [scale.x + x * scale.size, scale.y - y * scale.size];
}

/**
 * Return the box about a disc.
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 * @returns {Box}
 */
export function boxAbout(x, y, radius) {
  return { left: x - radius, right: x + radius, low: y - radius, high: y + radius };
}

/**
 * Return the box that holds some boxes.
 * @param {Box[]} boxes
 * @returns {Box}
 */
export function joined(boxes) {
  return { left: Math.min(...boxes.map(({ left }) => left)), right: Math.max(...boxes.map(({ right }) => right)),
    low: Math.min(...boxes.map(({ low }) => low)), high: Math.max(...boxes.map(({ high }) => high)) };
}

/**
 * Return a box on the way from one to another.
 * @param {Box} a
 * @param {Box} b
 * @param {number} share of the way
 * @returns {Box}
 */
export function between(a, b, share) {
  const mean = (/** @type {keyof Box} */ end) => a[end] + share * (b[end] - a[end]);
  return { left: mean("left"), right: mean("right"), low: mean("low"), high: mean("high") };
}

/**
 * Draw a straight line.
 * @param {CanvasRenderingContext2D} context
 * @param {number} x0
 * @param {number} y0
 * @param {number} x1
 * @param {number} y1
 */
export function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

/**
 * Return the path of an upright cross.
 * @param {number} x
 * @param {number} y
 * @param {number} reach how far its arms go
 */
export function cross(x, y, reach) {
  const path = new Path2D();
  path.moveTo(x - reach, y);
  path.lineTo(x + reach, y);
  path.moveTo(x, y - reach);
  path.lineTo(x, y + reach);
  return path;
}

/**
 * Draw a path with one pen over the other: a narrow light one over a wide dark one, or the other
 * way round, is seen on any ground.
 * @param {CanvasRenderingContext2D} context
 * @param {Path2D} path
 * @param {...[paint: string, width: number, dash?: number[]]} pens
 */
export function outline(context, path, ...pens) {
  for (const [paint, width, dash = []] of pens) {
    context.strokeStyle = paint;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.stroke(path);
  }
  context.setLineDash([]);
}
