/** The player in a notebook: what anywidget calls. */

import { unpack } from "./shared/block.js";
import { el } from "./shared/dom.js";
import { Motion } from "./shared/motion.js";
import { Player } from "./shared/player.js";

// Keys beside letters, digits and signs that the player or its fields use.
const KEYS = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp",
  "PageDown", "Enter"];
// Text that is lighter than this, of 255, is written on dark.
const LIGHT = 128;

/**
 * Return whether a key is the player's while the player has the focus. Shortcuts with Ctrl, Alt or
 * Meta, Shift+Enter, Escape and Tab remain the notebook's.
 * @param {Pick<KeyboardEvent, "key" | "ctrlKey" | "metaKey" | "altKey" | "shiftKey">} event
 */
export function isOwnKey({ key, ctrlKey, metaKey, altKey, shiftKey }) {
  if (ctrlKey || metaKey || altKey || (shiftKey && key === "Enter")) return false;
  return key.length === 1 || KEYS.includes(key);
}

/**
 * Return the theme around an element: as JupyterLab and VS Code say it, else dark where text is
 * light; null for an element that is not in the page.
 * @param {Element} element
 */
export function themeAround(element) {
  const { body } = document;
  if (body.dataset.jpThemeLight) return body.dataset.jpThemeLight === "true" ? "light" : "dark";
  if (body.classList.contains("vscode-dark")) return "dark";
  if (body.classList.contains("vscode-light")) return "light";
  const { color } = getComputedStyle(element);
  const context = el("canvas", { width: 1, height: 1 }).getContext("2d");
  if (!color || !context) return null;
  // Colours may be written in any way: a pixel has red, green and blue.
  context.fillStyle = color;
  context.fillRect(0, 0, 1, 1);
  const [red, green, blue] = context.getImageData(0, 0, 1, 1).data;
  return 0.3 * red + 0.6 * green + 0.1 * blue > LIGHT ? "dark" : "light";
}

/**
 * Keep the theme of an element that of the page around it; returns what ends that.
 * @param {HTMLElement} host
 */
export function followTheme(host) {
  const follow = () => {
    const theme = themeAround(host);
    if (!theme || theme === host.dataset.theme) return;
    host.dataset.theme = theme;
    window.dispatchEvent(new Event("themechange"));
  };
  const page = new MutationObserver(follow);
  for (const element of [document.documentElement, document.body])
    page.observe(element, { attributes: true });
  // The element comes into the page, or out of a hidden cell.
  const size = new ResizeObserver(follow);
  size.observe(host);
  const system = matchMedia("(prefers-color-scheme: dark)");
  system.addEventListener("change", follow);
  follow();
  return () => {
    page.disconnect();
    size.disconnect();
    system.removeEventListener("change", follow);
  };
}

/**
 * Show a run in a cell; returns what takes it away again.
 * @param {{model: any, el: HTMLElement}} cell
 */
export function render({ model, el: cell }) {
  const host = el("div", {});
  const inside = host.attachShadow({ mode: "open" });
  const style = document.createElement("style");
  style.textContent = model.get("sheet");
  // A click anywhere gives the player the keyboard.
  const root = el("div", { class: "player notebook", tabindex: "-1" });
  inside.append(style, root);
  cell.append(host);
  // Some of the player's keys delete cells in notebooks.
  for (const name of ["keydown", "keypress", "keyup"])
    host.addEventListener(name, (event) => {
      if (isOwnKey(/** @type {KeyboardEvent} */ (event))) event.stopPropagation();
    });
  const unfollow = followTheme(host);
  const player = new Player(root);
  const show = () => {
    const { buffer, byteOffset, byteLength } = /** @type {DataView} */ (model.get("block"));
    player.show(new Motion(unpack(
      /** @type {ArrayBuffer} */ (buffer).slice(byteOffset, byteOffset + byteLength))));
  };
  model.on("change:block", show);
  show();
  return () => {
    model.off("change:block", show);
    player.destroy();
    unfollow();
    host.remove();
  };
}
