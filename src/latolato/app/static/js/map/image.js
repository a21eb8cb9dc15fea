/** The picture of a map as it is on the screen: its title, the map, the colour bar, the legend. */

import { colour } from "../page/dom.js";
import { t } from "../strings.js";
import { axisLabel } from "./axes.js";

/** @typedef {import("./view.js").MapView} MapView */

const PAD = 10;
const LINE = 18;
// Room for what a line of the legend explains.
const KEY = 30;

/**
 * Return the picture as a file.
 * @param {MapView} view
 * @returns {Promise<Blob>}
 */
export async function pictureOf({ chart, bar, grid, barTitle, classes }) {
  const ratio = window.devicePixelRatio || 1;
  const entries = /** @type {HTMLElement[]} */ ([...classes.children]);
  const { width } = chart.canvas;
  const barHeight = bar.canvas.hidden ? 0 : bar.canvas.height;
  const place = (/** @type {number} */ lines) => lines * LINE * ratio;
  const canvas = document.createElement("canvas");
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const font = (/** @type {boolean} */ isBold) => `${isBold ? "600 " : ""}${13 * ratio}px system-ui, sans-serif`;
  const broken = (/** @type {string} */ text, isBold = false, most = width) => {
    context.font = font(isBold);
    return brokenLines(context, text, most);
  };
  const title = broken(grid?.about.title || axisLabel(/** @type {any} */ (grid).y), true);
  const ofBar = broken(barTitle.textContent ?? "");
  const keys = entries.map((entry) => broken([...entry.childNodes].slice(1).map((node) => node.textContent).join(""),
    false, width - KEY * ratio));
  canvas.width = width + 2 * PAD * ratio;
  canvas.height = place([title, ofBar, ...keys].flat().length) + chart.canvas.height + barHeight + 2 * PAD * ratio;
  context.fillStyle = colour("card", chart.canvas);
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.translate(PAD * ratio, PAD * ratio);
  context.textBaseline = "top";
  let top = 0;
  const write = (/** @type {string[]} */ lines, x = 0, isBold = false) => {
    for (const line of lines) {
      context.fillStyle = colour("ink", chart.canvas);
      context.font = font(isBold);
      context.fillText(line, x, top);
      top += place(1);
    }
  };
  write(title, 0, true);
  context.drawImage(chart.canvas, 0, top);
  top += chart.canvas.height;
  write(ofBar);
  if (barHeight) context.drawImage(bar.canvas, 0, top);
  top += barHeight;
  entries.forEach((entry, k) => {
    drawKey(context, entry.querySelector("span"), top, ratio);
    write(keys[k], KEY * ratio);
  });
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error(t("refusePicture")))));
  });
}

/**
 * Return a text in lines that are no wider than so many pixels, if its words are not.
 * @param {CanvasRenderingContext2D} context with the font of the text
 * @param {string} text
 * @param {number} most
 */
function brokenLines(context, text, most) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const longer = `${lines[lines.length - 1]} ${word}`.trim();
    if (context.measureText(longer).width <= most) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}

/**
 * Draw what a line of the legend explains: a colour, a curve, or the mark of a trial.
 * @param {CanvasRenderingContext2D} context
 * @param {HTMLElement | null} key
 * @param {number} top
 * @param {number} ratio
 */
function drawKey(context, key, top, ratio) {
  if (!key) return;
  const { color, backgroundColor, borderTopColor, borderTopStyle } = getComputedStyle(key);
  const middle = top + 8 * ratio;
  context.lineWidth = ratio;
  if (key.textContent) {
    context.fillStyle = color;
    context.fillText(key.textContent, 0, top);
  } else if (key.classList.contains("swatch")) {
    context.fillStyle = backgroundColor;
    context.strokeStyle = color;
    context.fillRect(0, top + ratio, 14 * ratio, 14 * ratio);
    context.strokeRect(0.5, top + ratio + 0.5, 14 * ratio, 14 * ratio);
  } else {
    context.strokeStyle = borderTopColor;
    context.lineWidth = 2 * ratio;
    context.setLineDash(borderTopStyle === "dashed" ? [5 * ratio, 3 * ratio] : []);
    context.beginPath();
    context.moveTo(0, middle);
    context.lineTo((KEY - 6) * ratio, middle);
    context.stroke();
    context.setLineDash([]);
  }
}
