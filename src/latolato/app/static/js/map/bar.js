/** The colour bar of a map, with its numbers. */

import { ticks } from "../shared/axis.js";
import { colour, fitCanvas } from "../shared/dom.js";
import { localShort } from "../shared/units.js";
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
    context.strokeStyle = context.fillStyle = colour("soft", this.canvas);
    context.font = `${12 * ratio}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "top";
    context.lineWidth = ratio;
    const marks = log ? powers(low, high) : ticks(low, high, Math.max(2, width / (70 * ratio)));
    for (const mark of marks) {
      const share = log ? Math.log(mark / low) / Math.log(high / low) : (mark - low) / (high - low);
      const x = left + share * width;
      context.beginPath();
      context.moveTo(x, height);
      context.lineTo(x, height + 4 * ratio);
      context.stroke();
      context.fillText(localShort(mark, 4), x, height + 5 * ratio);
    }
  }
}

/**
 * Return about six powers of ten between two values, or these themselves.
 * @param {number} low
 * @param {number} high
 */
function powers(low, high) {
  const first = Math.ceil(Math.log10(low) - 1e-9);
  const last = Math.floor(Math.log10(high) + 1e-9);
  const step = Math.max(1, Math.round((last - first) / 6));
  const ticks = [];
  for (let k = first; k <= last; k += step) ticks.push(10 ** k);
  return ticks.length > 1 ? ticks : [low, high];
}
