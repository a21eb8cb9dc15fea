/** A picture of one quantity over another: curves, dots and a mark that moves. */

import { axisLimits, SINGLE, ticks } from "./axis.js";
import { colour, fitCanvas } from "./dom.js";
import { range } from "./motion.js";
import { localShort } from "./units.js";

const LEFT = 52;
const BELOW = 34;
const ABOVE = 10;
const RIGHT = 12;
// Of the range of what is shown.
const MARGIN = 0.06;

/** @typedef {{xs: ArrayLike<number>, ys: ArrayLike<number>, paint: string, dots?: boolean,
 *   size?: number}} Shape */

export class Plane {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{x: string, y: string}} labels
   */
  constructor(canvas, labels) {
    this.canvas = canvas;
    this.labels = labels;
    /** @type {Shape[]} */
    this.shapes = [];
    /** @type {{x: number, y: number, paint: string}[]} */
    this.marks = [];
    this.limits = { x: [-1, 1], y: [-1, 1] };
    this.still = document.createElement("canvas");
    /** @type {Map<string, string>} colours of the style sheet, read once for each theme */
    this.colours = new Map();
    // Marks that move are drawn where somebody sees them.
    this.isSeen = true;
    const observer = new IntersectionObserver((entries) => {
      this.isSeen = entries[entries.length - 1].isIntersecting;
      if (this.isSeen) this.draw();
    });
    observer.observe(canvas);
    const release = fitCanvas(canvas, () => this.redraw());
    this.release = () => {
      observer.disconnect();
      release();
    };
  }

  /**
   * Show shapes, in limits that hold them all.
   * @param {Shape[]} shapes
   */
  show(shapes) {
    this.shapes = shapes;
    for (const axis of /** @type {("x" | "y")[]} */ (["x", "y"])) {
      const ends = shapes.flatMap((s) => range(axis === "x" ? s.xs : s.ys));
      const [low, high] = axisLimits(...range(ends), SINGLE);
      const margin = MARGIN * (high - low);
      this.limits[axis] = [low - margin, high + margin];
    }
    this.redraw();
  }

  /**
   * Move the marks without drawing the rest again.
   * @param {{x: number, y: number, paint: string}[]} marks
   */
  mark(marks) {
    this.marks = marks;
    if (this.isSeen) this.draw();
  }

  /** Return the part of the canvas that the axes enclose, in its own pixels. */
  frame() {
    const ratio = window.devicePixelRatio || 1;
    return {
      left: LEFT * ratio,
      top: ABOVE * ratio,
      width: Math.max(1, this.canvas.width - (LEFT + RIGHT) * ratio),
      height: Math.max(1, this.canvas.height - (ABOVE + BELOW) * ratio),
    };
  }

  /** The functions that turn a quantity into a position on the canvas, in its own pixels, by axis. */
  places() {
    const { left, top, width, height } = this.frame();
    const { x: [x0, x1], y: [y0, y1] } = this.limits;
    const across = width / (x1 - x0);
    const down = height / (y1 - y0);
    return {
      x: (/** @type {number} */ x) => left + (x - x0) * across,
      y: (/** @type {number} */ y) => top + (y1 - y) * down,
    };
  }

  /**
   * The position of a point on the canvas, in the canvas's own pixels.
   * @param {number} x
   * @param {number} y
   */
  place(x, y) {
    const to = this.places();
    return [to.x(x), to.y(y)];
  }

  /**
   * Return a colour of the style sheet.
   * @param {string} name
   */
  paint(name) {
    let paint = this.colours.get(name);
    if (paint === undefined) {
      paint = colour(name, this.canvas);
      this.colours.set(name, paint);
    }
    return paint;
  }

  redraw() {
    const { canvas, still } = this;
    this.colours.clear();
    still.width = canvas.width;
    still.height = canvas.height;
    const context = still.getContext("2d");
    if (!context) return;
    this.drawAxes(context);
    const ratio = window.devicePixelRatio || 1;
    const { left, top, width, height } = this.frame();
    context.save();
    context.beginPath();
    context.rect(left, top, width, height);
    context.clip();
    for (const shape of this.shapes) {
      context.strokeStyle = context.fillStyle = this.paint(shape.paint);
      if (shape.dots) this.drawDots(context, shape, (shape.size ?? 2) * ratio);
      else this.drawLine(context, shape, ratio);
    }
    context.restore();
    this.draw();
  }

  /** @param {CanvasRenderingContext2D} context */
  drawAxes(context) {
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    const { left, top, width, height } = this.frame();
    context.font = `${12 * ratio}px system-ui, sans-serif`;
    context.fillStyle = this.paint("soft");
    context.strokeStyle = this.paint("grid");
    context.lineWidth = ratio;
    context.textAlign = "center";
    context.textBaseline = "top";
    for (const x of ticks(...pair(this.limits.x), Math.max(2, width / (70 * ratio)))) {
      const [px] = this.place(x, 0);
      segment(context, px, top, px, top + height);
      context.fillText(localShort(x, 4), px, top + height + 4 * ratio);
    }
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const y of ticks(...pair(this.limits.y), Math.max(2, height / (45 * ratio)))) {
      const [, py] = this.place(0, y);
      segment(context, left, py, left + width, py);
      context.fillText(localShort(y, 4), left - 5 * ratio, py);
    }
    context.textAlign = "center";
    context.textBaseline = "bottom";
    context.fillText(this.labels.x, left + width / 2, canvas.height - ratio);
    context.save();
    context.translate(ratio, top + height / 2);
    context.rotate(-Math.PI / 2);
    context.textBaseline = "top";
    context.fillText(this.labels.y, 0, 0);
    context.restore();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {Shape} shape
   * @param {number} ratio
   */
  drawLine(context, { xs, ys }, ratio) {
    context.lineWidth = ratio;
    context.beginPath();
    const to = this.places();
    let open = false;
    for (let i = 0; i < xs.length; i += 1) {
      const [x, y] = [to.x(xs[i]), to.y(ys[i])];
      if (Number.isNaN(x + y)) open = false;
      else if (open) context.lineTo(x, y);
      else {
        context.moveTo(x, y);
        open = true;
      }
    }
    context.stroke();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {Shape} shape
   * @param {number} size
   */
  drawDots(context, { xs, ys }, size) {
    const to = this.places();
    for (let i = 0; i < xs.length; i += 1) {
      const [x, y] = [to.x(xs[i]), to.y(ys[i])];
      if (!Number.isNaN(x + y)) context.fillRect(x - size / 2, y - size / 2, size, size);
    }
  }

  draw() {
    const context = this.canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (this.still.width) context.drawImage(this.still, 0, 0);
    const ratio = window.devicePixelRatio || 1;
    for (const { x, y, paint } of this.marks) {
      const [px, py] = this.place(x, y);
      context.beginPath();
      context.arc(px, py, 5 * ratio, 0, 2 * Math.PI);
      context.fillStyle = this.paint(paint);
      context.fill();
      context.strokeStyle = this.paint("paper");
      context.lineWidth = 1.5 * ratio;
      context.stroke();
    }
  }
}

/** @param {number[]} values @returns {[number, number]} */
function pair(values) {
  return [values[0], values[1]];
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x0
 * @param {number} y0
 * @param {number} x1
 * @param {number} y1
 */
function segment(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
