/** The picture of a map: cells, axes, curves, trials, the cross, and what the hand does on it. */

import { axisLimits } from "../player/axis.js";
import { colour, fitCanvas } from "../page/dom.js";
import { outline } from "../player/canvas.js";
import { drawAxes, MARGIN, shareOf } from "./axes.js";
import { colourTable, pixelOf } from "./colours.js";
import { drawContours } from "./contours.js";
import { cellAt, NOT_YET } from "./grid.js";
import { drawCross, drawLine, drawTrials } from "./marks.js";
import { classesOf } from "./class_words.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {{variable: number, scale: string, log: boolean, limits: [number, number]}} Look */
/** @typedef {{xs: ArrayLike<number>, ys: ArrayLike<number>, kinds: ArrayLike<number>}} Trials */
/** @typedef {import("./contours.js").Contour} Contour */
/** @typedef {[number, number, number, number]} ChartBox x from, x to, y from, y to */

const LEFT = MARGIN;
const BELOW = 40;
const ABOVE = 8;
const RIGHT = 14;
// What lies over a picture of an older question: so much of the card's colour.
const VEIL = 0.62;

export class MapChart {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Grid | null} */
    this.grid = null;
    /** @type {Look} */
    this.look = { variable: 0, scale: "viridis", log: false, limits: [0, 1] };
    /** @type {import("./overlay_curves.js").Line[]} */
    this.lines = [];
    /** @type {Contour[]} */
    this.contours = [];
    /** @type {Trials | null} */
    this.trials = null;
    /** @type {[number, number] | null} values at the cross */
    this.cross = null;
    /** @type {ChartBox | null} */
    this.band = null;
    this.shift = [0, 0];
    /** Whether this is the picture of an older question. */
    this.isOld = false;
    this.cells = document.createElement("canvas");
    this.release = fitCanvas(canvas, () => this.paint());
  }

  /** Return the part of the canvas that the axes enclose, in its own pixels. */
  frame() {
    const ratio = window.devicePixelRatio || 1;
    return {
      left: Math.round(LEFT * ratio),
      top: Math.round(ABOVE * ratio),
      width: Math.max(1, Math.round(this.canvas.width - (LEFT + RIGHT) * ratio)),
      height: Math.max(1, Math.round(this.canvas.height - (ABOVE + BELOW) * ratio)),
    };
  }

  /**
   * Return the ends of an axis: the outer borders of its cells.
   * @param {"x" | "y"} which
   * @returns {[number, number]}
   */
  ends(which) {
    const edges = this.grid?.[which].edges ?? [0, 1];
    return axisLimits(edges[0], edges[edges.length - 1]);
  }

  /**
   * Return the share of an axis that lies before a value.
   * @param {"x" | "y"} which
   * @param {number} value
   */
  share(which, value) {
    const [low, high] = this.ends(which);
    return shareOf({ low, high, log: this.grid?.[which].log }, value);
  }

  /**
   * Return the value at a share of an axis.
   * @param {"x" | "y"} which
   * @param {number} share
   */
  value(which, share) {
    const [low, high] = this.ends(which);
    return this.grid?.[which].log ? low * (high / low) ** share : low + share * (high - low);
  }

  /**
   * The position on the canvas of a point of the map, in the canvas's own pixels.
   * @param {number} x
   * @param {number} y
   */
  place(x, y) {
    const { left, top, width, height } = this.frame();
    return [left + this.share("x", x) * width, top + (1 - this.share("y", y)) * height];
  }

  /**
   * Return the values at a place of the page, null outside of the axes.
   * @param {{clientX: number, clientY: number}} event
   * @param {boolean} [clamp] move it to the border instead
   * @returns {[number, number] | null}
   */
  at(event, clamp = false) {
    if (!this.grid) return null;
    const box = this.canvas.getBoundingClientRect();
    const { left, top, width, height } = this.frame();
    const zoom = this.canvas.width / box.width;
    let u = ((event.clientX - box.left) * zoom - left) / width;
    let v = 1 - ((event.clientY - box.top) * zoom - top) / height;
    if (clamp) [u, v] = [Math.min(Math.max(u, 0), 1), Math.min(Math.max(v, 0), 1)];
    if (u < 0 || u > 1 || v < 0 || v > 1) return null;
    return [this.value("x", u), this.value("y", v)];
  }

  /**
   * Return the number of the cell at these values, -1 outside.
   * @param {number} x
   * @param {number} y
   */
  cell(x, y) {
    if (!this.grid) return -1;
    const column = cellAt(this.grid.x.edges, x);
    const line = cellAt(this.grid.y.edges, y);
    return column < 0 || line < 0 ? -1 : line * this.grid.width + column;
  }

  /** Colour the cells, then draw all. */
  paint() {
    const { width, height } = this.frame();
    this.cells.width = width;
    this.cells.height = height;
    const context = this.cells.getContext("2d");
    if (!context || !this.grid) return this.draw();
    const { grid } = this;
    const image = context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const colours = this.colours();
    const columns = new Int32Array(width);
    for (let i = 0; i < width; i += 1)
      columns[i] = Math.max(0, cellAt(grid.x.edges, this.value("x", (i + 0.5) / width)));
    for (let j = 0; j < height; j += 1) {
      // The first line of pixels is the top, the first row of cells the bottom.
      const line = Math.max(0, cellAt(grid.y.edges, this.value("y", 1 - (j + 0.5) / height)));
      const from = line * grid.width;
      for (let i = 0; i < width; i += 1) pixels[j * width + i] = colours[from + columns[i]];
    }
    context.putImageData(image, 0, 0);
    this.draw();
  }

  /** Return the pixel of every cell. */
  colours() {
    const grid = /** @type {Grid} */ (this.grid);
    const { variable, scale, log, limits } = this.look;
    const values = grid.values[variable];
    const { status } = grid;
    const table = colourTable(scale);
    const { classes, place } = classesOf(grid, variable);
    const paints = classes.map(([, text]) => pixelOf(text));
    const [notYet, none, zero] = ["tint", "faint", "paper"].map((name) => pixelOf(colour(name, this.canvas)));
    const [low, high] = log ? limits.map((v) => Math.log(Math.max(v, 1e-300))) : limits;
    const factor = 255 / (high - low || 1);
    const pixels = new Uint32Array(values.length);
    for (let i = 0; i < values.length; i += 1) {
      const value = values[i];
      if (status[i] === NOT_YET) pixels[i] = notYet;
      else if (Number.isNaN(value)) pixels[i] = none;
      else if (log && value <= 0) pixels[i] = zero;
      else if (paints.length) pixels[i] = paints[place(value)] ?? none;
      else {
        const place = ((log ? Math.log(value) : value) - low) * factor;
        pixels[i] = table[place > 0 ? Math.min(255, Math.round(place)) : 0];
      }
    }
    return pixels;
  }

  draw() {
    const context = this.canvas.getContext("2d");
    if (!context) return;
    const ratio = window.devicePixelRatio || 1;
    const { left, top, width, height } = this.frame();
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (!this.grid) return;
    context.save();
    context.beginPath();
    context.rect(left, top, width, height);
    context.clip();
    context.translate(this.shift[0], this.shift[1]);
    if (this.cells.width) context.drawImage(this.cells, left, top);
    const drawValues = this.contours.length
      ? drawContours(this, context, this.contours, ratio) : () => {};
    for (const each of this.lines) drawLine(this, context, each, ratio);
    drawValues();
    if (this.trials) drawTrials(this, context, this.trials, ratio);
    if (this.cross) drawCross(this, context, this.cross, ratio);
    if (this.isOld) {
      context.globalAlpha = VEIL;
      context.fillStyle = colour("card", this.canvas);
      context.fillRect(left, top, width, height);
    }
    context.restore();
    if (this.band) {
      const [a, b] = this.place(this.band[0], this.band[3]);
      const [c, d] = this.place(this.band[1], this.band[2]);
      const path = new Path2D();
      path.rect(a, b, c - a, d - b);
      outline(context, path, ["#ffffff", 3 * ratio], ["#000000", ratio]);
    }
    drawAxes(this, context, ratio);
  }
}
