/** The colour bar of a map, with its numbers. */

import { fitCanvas } from "../page/dom.js";
import { drawTicks } from "./axes.js";
import { colourTable } from "./colours.js";

/** @typedef {import("./chart.js").Look} Look */

const SIDE = 26;
const HEIGHT = 14;

export class ColourBar {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Look | null} */
    this.look = null;
    this.size = 1;
    this.release = fitCanvas(canvas, () => this.draw());
  }

  /**
   * Show a look; `size` is how many SI units the shown unit is.
   * @param {Look} look
   * @param {number} size
   */
  show(look, size) {
    this.look = look;
    this.size = size;
    this.draw();
  }

  draw() {
    const context = this.canvas.getContext("2d");
    if (!context || !this.look) return;
    const ratio = window.devicePixelRatio || 1;
    const { scale, log, limits } = this.look;
    const [low, high] = limits.map((v) => v / this.size);
    const left = SIDE * ratio;
    const width = Math.max(1, this.canvas.width - 2 * left);
    const height = HEIGHT * ratio;
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    const table = colourTable(scale);
    const image = context.createImageData(Math.round(width), Math.round(height));
    const pixels = new Uint32Array(image.data.buffer);
    for (let i = 0; i < pixels.length; i += 1)
      pixels[i] = table[Math.floor((256 * (i % image.width)) / image.width)];
    context.putImageData(image, left, 1);
    drawTicks(context, { x: left, y: height, length: width }, { low, high, log }, ratio);
  }
}
