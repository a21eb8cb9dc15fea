/** A player in another page, such as a notebook: its root, its style, and the theme around it. */

import { contentOf } from "../kernels/content.js";
import { loadRegistry } from "../model/registry.js";
import { el } from "../page/dom.js";
import { Motion } from "./motion.js";
import { Player } from "./player.js";
import { Runner } from "./runner.js";

/** @typedef {import("../page/block.js").Block} Block */

const SHEETS = ["vendor/uPlot.css", "app.css", "toy.css", "inset.css"];
// Text that is lighter than this, of 255, is written on dark.
const LIGHT = 128;

/** @type {Promise<CSSStyleSheet> | null} */
let sheet = null;

/** Return the style of what has a root of its own; it is loaded once. */
function loadSheet() {
  sheet ??= Promise.all(SHEETS.map(async (path) => (await contentOf(path)).text())).then((texts) => {
    const made = new CSSStyleSheet();
    made.replaceSync(texts.join("\n").replace(/:root((?:\[[^\]]*\]|:not\([^)]*\))+)/g, ":host($1)")
      .replaceAll(":root", ":host"));
    return made;
  });
  return sheet;
}

/** A player inside of an element that belongs to another page. */
export class EmbeddedPlayer {
  /** @param {HTMLElement} host */
  constructor(host) {
    this.host = host;
    this.inside = host.shadowRoot ?? host.attachShadow({ mode: "open" });
    this.message = el("p", { class: "error", role: "alert", hidden: true });
    // A click anywhere gives the player the keyboard.
    const stage = el("div", { class: "player", tabindex: "-1" });
    this.inside.replaceChildren(el("div", { class: "inset" }, this.message, stage));
    this.player = new Player(stage);
    /** @type {Runner | null} */
    this.runner = null;
    this.unfollow = followTheme(host);
  }

  /** Load what a player needs. */
  async load() {
    const [registry, style] = await Promise.all([loadRegistry(), loadSheet()]);
    this.inside.adoptedStyleSheets = [style];
    this.runner ??= new Runner(registry);
    return registry;
  }

  /** @param {Block} block */
  show(block) {
    this.player.show(new Motion(block));
    this.refuse(null);
  }

  /**
   * Say why there is no run.
   * @param {string | null} text
   */
  refuse(text) {
    this.message.textContent = text;
    this.message.hidden = text === null;
  }

  /**
   * Show the run that a request asks for and return it, or null where a newer one is wanted.
   * @param {import("../model/options.js").OptionsRequest} request
   * @returns {Promise<Block | null>}
   * @throws {import("../model/rules.js").InputError} for bad input
   */
  async compute(request) {
    try {
      const block = await /** @type {Runner} */ (this.runner).compute(request);
      this.show(block);
      return block;
    } catch (error) {
      if (/** @type {Error} */ (error).name === "AbortError") return null;
      throw error;
    }
  }

  /** Remove the player. */
  leave() {
    this.unfollow();
    this.runner?.end();
    this.player.destroy();
    this.inside.replaceChildren();
  }
}

/**
 * Return the theme around an element: as JupyterLab and VS Code name it, else dark where text is
 * light; null for an element that is not in the page.
 * @param {Element} element
 */
function themeAround(element) {
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
 * Keep the theme of an element like that of the page around it; returns a function that ends this.
 * @param {HTMLElement} host
 */
function followTheme(host) {
  const follow = () => {
    const theme = themeAround(host);
    if (!theme || theme === host.dataset.theme) return;
    host.dataset.theme = theme;
    window.dispatchEvent(new Event("themechange"));
  };
  const page = new MutationObserver(follow);
  for (const element of [document.documentElement, document.body])
    page.observe(element, { attributes: true });
  // The element enters the page or becomes visible.
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
