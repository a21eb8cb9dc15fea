/** The player in a notebook: what anywidget calls. */

import { unpack } from "./block.js";
import { el } from "./dom.js";
import { Motion } from "./motion.js";
import { Player } from "./player.js";

/** Return whether the notebook around is dark; null where it does not say. */
function notebookTheme() {
  const { body } = document;
  if (body.dataset.jpThemeLight) return body.dataset.jpThemeLight === "true" ? "light" : "dark";
  if (body.classList.contains("vscode-dark")) return "dark";
  if (body.classList.contains("vscode-light")) return "light";
  return null;
}

/**
 * Show a run in a cell; returns what takes it away again.
 * @param {{model: any, el: HTMLElement}} cell
 */
export function render({ model, el: cell }) {
  const host = el("div", {});
  const theme = notebookTheme();
  if (theme) host.dataset.theme = theme;
  const inside = host.attachShadow({ mode: "open" });
  const style = document.createElement("style");
  style.textContent = model.get("style");
  const root = el("div", { class: "player notebook" });
  inside.append(style, root);
  cell.append(host);
  const player = new Player(root);
  const show = () => {
    const bytes = /** @type {DataView} */ (model.get("block"));
    const { buffer, byteOffset, byteLength } = bytes;
    player.show(new Motion(unpack(
      /** @type {ArrayBuffer} */ (buffer).slice(byteOffset, byteOffset + byteLength))));
  };
  model.on("change:block", show);
  show();
  return () => {
    model.off("change:block", show);
    player.destroy();
  };
}
