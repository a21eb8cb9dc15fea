/** The stage as a picture to share: as it is drawn, with a title and a caption below it. */

import { colour } from "./dom.js";

const LINE = 22;

/**
 * Return the main numbers of a run in a line.
 * @param {Record<string, any>} options of the run, in SI units
 */
export function captionOf(options) {
  return [options.system, options.drive].filter(Boolean).join(" · ");
}

/**
 * Return a PNG of what a scene shows.
 * @param {import("./scene.js").Scene} scene
 * @param {{title: string, caption: string}} words
 * @returns {Promise<Blob>}
 */
export async function stagePicture({ canvas: stage }, { title, caption }) {
  const canvas = document.createElement("canvas");
  const ratio = window.devicePixelRatio || 1;
  [canvas.width, canvas.height] = [stage.width, stage.height + 2.5 * LINE * ratio];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.fillStyle = colour("card", stage);
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(stage, 0, 0);
  context.fillStyle = colour("ink", stage);
  context.font = `${15 * ratio}px system-ui, sans-serif`;
  [title, caption].forEach((text, i) =>
    context.fillText(text, LINE * ratio, stage.height + (i + 1) * LINE * ratio));
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the browser makes no picture"))));
  });
}
