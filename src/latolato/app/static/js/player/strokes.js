/** Lines on canvases. */

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
