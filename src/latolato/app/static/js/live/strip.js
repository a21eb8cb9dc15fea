/** A curve that scrolls: the last seconds of some quantities. */

import { axisLimits, ticks } from "../shared/axis.js";
import { colour, fitCanvas } from "../shared/dom.js";
import { localShort } from "../shared/units.js";
import { SPAN } from "./motion.js";

/** @typedef {import("./motion.js").History} History */

const LEFT = 52;
const BELOW = 22;
const ABOVE = 10;
const RIGHT = 10;
// The limits shrink by this share of their distance in a frame, and grow at once.
const EASE = 0.02;
// A curve is drawn in pieces of so many points: without a graphics card that takes half the time.
const PIECE = 32;

export class Strip {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{curves: {name: string, paint: string, dash?: number[]}[],
   *   least: [number, number]}} how `least` is shown always
   */
  constructor(canvas, { curves, least }) {
    this.canvas = canvas;
    this.curves = curves;
    this.least = least;
    this.limits = [...least];
    /** @type {History | null} */
    this.history = null;
    /** Instants to mark, such as contacts [s]. */
    this.marks = /** @type {number[]} */ ([]);
    this.colours = this.readColours();
    this.release = fitCanvas(canvas, () => {
      this.colours = this.readColours();
      this.draw();
    });
  }

  /** Return the colours of the style sheet, read once for each theme. */
  readColours() {
    /** @type {Record<string, string>} */
    const colours = {};
    for (const name of ["soft", "grid", "flash", ...this.curves.map((c) => c.paint)])
      colours[name] = colour(name, this.canvas);
    return colours;
  }

  /** Return the part of the canvas that the curves fill, in its own pixels. */
  frame() {
    const ratio = window.devicePixelRatio || 1;
    return {
      ratio,
      left: LEFT * ratio,
      top: ABOVE * ratio,
      width: Math.max(1, this.canvas.width - (LEFT + RIGHT) * ratio),
      height: Math.max(1, this.canvas.height - (ABOVE + BELOW) * ratio),
    };
  }

  follow() {
    const { history, curves, least, limits } = this;
    if (!history) return;
    const [low, high] = history.range(curves.map((c) => c.name));
    const aim = axisLimits(Math.min(least[0], low), Math.max(least[1], high));
    const margin = 0.05 * (aim[1] - aim[0]);
    if (low < least[0]) aim[0] -= margin;
    if (high > least[1]) aim[1] += margin;
    limits[0] = aim[0] < limits[0] ? aim[0] : limits[0] + EASE * (aim[0] - limits[0]);
    limits[1] = aim[1] > limits[1] ? aim[1] : limits[1] + EASE * (aim[1] - limits[1]);
  }

  /** Draw the last seconds; the newest instant is at the right end. */
  draw() {
    const { canvas, history } = this;
    const context = canvas.getContext("2d");
    if (!context) return;
    this.follow();
    context.clearRect(0, 0, canvas.width, canvas.height);
    const { left, top, width, height, ratio } = this.frame();
    const [low, high] = this.limits;
    const place = (/** @type {number} */ v) => top + ((high - v) / (high - low || 1)) * height;
    context.font = `${12 * ratio}px system-ui, sans-serif`;
    context.fillStyle = this.colours.soft;
    context.strokeStyle = this.colours.grid;
    context.lineWidth = ratio;
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const value of ticks(low, high, Math.max(2, height / (34 * ratio)))) {
      const y = place(value);
      stroke(context, left, y, left + width, y);
      context.fillText(localShort(value, 4), left - 5 * ratio, y);
    }
    context.textAlign = "center";
    context.textBaseline = "top";
    for (let s = 0; s <= SPAN; s += 5) {
      const x = left + width * (1 - s / SPAN);
      stroke(context, x, top, x, top + height);
      context.fillText(s ? `−${s}` : "0", x, top + height + 5 * ratio);
    }
    if (!history?.count) return;
    const now = history.time[history.at(history.count - 1)];
    const across = (/** @type {number} */ time) => left + width * (1 - (now - time) / SPAN);
    context.save();
    context.beginPath();
    context.rect(left, top - ratio, width + ratio, height + 2 * ratio);
    context.clip();
    context.strokeStyle = this.colours.flash;
    context.lineWidth = 1.5 * ratio;
    for (const time of this.marks)
      stroke(context, across(time), top, across(time), top + 7 * ratio);
    for (const { name, paint, dash } of this.curves) {
      const values = history.values[name];
      context.strokeStyle = this.colours[paint];
      context.lineWidth = 1.6 * ratio;
      context.setLineDash((dash ?? []).map((d) => d * ratio));
      for (let first = 0; first + 1 < history.count; first += PIECE) {
        context.beginPath();
        for (let k = first; k <= Math.min(first + PIECE, history.count - 1); k += 1) {
          const i = history.at(k);
          context.lineTo(across(history.time[i]), place(values[i]));
        }
        context.stroke();
      }
    }
    context.restore();
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x0
 * @param {number} y0
 * @param {number} x1
 * @param {number} y1
 */
function stroke(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
