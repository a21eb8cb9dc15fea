/** The stage as a picture to share: as it is drawn, with a caption below it. */

import { localList, t } from "../strings.js";
import { colour } from "../page/dom.js";
import { short } from "../page/unit_text.js";

/** @typedef {import("./scene.js").Scene} Scene */

// Pixels of the picture for one of the page.
const RATIO = 2;
// In pixels of the page.
const PADDING = 14;
const TITLE = { size: 17, weight: 650, paint: "ink" };
const CAPTION = { size: 14, weight: 400, paint: "soft" };
const LINE = 1.35;
const FONT = 'system-ui, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif';

/**
 * Return the main numbers of a run in a line: how far the hand moves, how often, and how bouncy the
 * balls are, as far as the run has these.
 * @param {Record<string, any>} options of the run, in SI units
 */
export function captionOf(options) {
  const listed = (/** @type {number | number[]} */ values, /** @type {number} */ size) =>
    localList([values].flat().map((value) => short(value / size, 3)));
  const frequency = options.drive_frequency ?? options.drive_frequencies;
  return [
    options.drive_amplitude && t("captionAmplitude", { value: listed(options.drive_amplitude, 1e-3) }),
    frequency && t("captionFrequency", { value: listed(frequency, 2 * Math.PI) }),
    options.restitution !== undefined && t("captionRestitution", { value: listed(options.restitution, 1) }),
  ].filter(Boolean).join(" · ");
}

/**
 * Return a PNG of what a scene shows, in its colours, with a title and a caption below it.
 * @param {Scene} scene
 * @param {{title: string, caption: string}} words
 * @returns {Promise<Blob>}
 */
export async function stagePicture(scene, { title, caption }) {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser makes no pictures");
  const { width: across, height: down } = scene.canvas;
  const size = RATIO / (window.devicePixelRatio || 1);
  const [width, height] = [Math.round(across * size), Math.round(down * size)];
  const padding = RATIO * PADDING;
  const lines = [{ text: title, style: TITLE }, { text: caption, style: CAPTION }].filter(({ text }) => text);
  const tall = (/** @type {typeof TITLE} */ style) => RATIO * LINE * style.size;
  canvas.width = width;
  canvas.height = height + Math.round(2 * padding + lines.reduce((sum, { style }) => sum + tall(style), 0));
  const paint = (/** @type {string} */ name) => colour(name, scene.canvas);
  context.fillStyle = paint("card");
  context.fillRect(0, 0, width, height);
  context.save();
  context.rect(0, 0, width, height);
  context.clip();
  scene.paint({ context, scale: scene.scale(width, height, RATIO), colours: scene.colours });
  context.restore();
  context.fillStyle = paint("tint");
  context.fillRect(0, height, width, canvas.height - height);
  context.textBaseline = "middle";
  let row = height + padding;
  for (const { text, style } of lines) {
    context.font = `${style.weight} ${RATIO * style.size}px ${FONT}`;
    context.fillStyle = paint(style.paint);
    // A text that is too long for its line is written narrower.
    context.fillText(text, padding, row + 0.5 * tall(style), width - 2 * padding);
    row += tall(style);
  }
  return new Promise((resolve, reject) => canvas.toBlob((blob) =>
    (blob ? resolve(blob) : reject(new Error("this browser makes no pictures"))), "image/png"));
}
