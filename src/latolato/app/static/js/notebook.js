/** The player in a notebook: what anywidget calls. */

import { commandLine, pythonLines } from "./model/run_code.js";
import { optionsOf } from "./model/options.js";
import { loadRegistry } from "./model/registry.js";
import { unpack } from "./page/block.js";
import { codeBlocks } from "./page/code.js";
import { el } from "./page/dom.js";
import { EmbeddedPlayer } from "./player/embedded.js";
import { Knobs } from "./page/knobs.js";
import { speakTable } from "./page/language.js";
import { withOptions } from "./page/option_texts.js";
import { inPagesWords, warningsText } from "./page/refusals.js";
import { withStart } from "./player/start.js";
import { t } from "./strings.js";

/** @typedef {import("./model/registry.js").Registry} Registry */
/** @typedef {import("./page/block.js").Block} Block */

// Keys beside letters, digits and signs that the player or its fields use.
const KEYS = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp",
  "PageDown", "Enter", "Backspace", "Delete"];
// What the run of a cell is called among the presets.
const OWN = "cell";

/**
 * Return whether a key is the player's while the player has the focus. Shortcuts with Ctrl, Alt or
 * Meta, Shift+Enter, Escape and Tab remain the notebook's.
 * @param {Pick<KeyboardEvent, "key" | "ctrlKey" | "metaKey" | "altKey" | "shiftKey">} event
 */
export function isOwnKey({ key, ctrlKey, metaKey, altKey, shiftKey }) {
  if (ctrlKey || metaKey || altKey || (shiftKey && key === "Enter")) return false;
  return key.length === 1 || KEYS.includes(key);
}

/** Knobs for the run of a cell: the page computes what they ask for. */
class Controls {
  /**
   * @param {EmbeddedPlayer} inset
   * @param {Registry} registry
   * @param {Block} block the run of the cell
   */
  constructor(inset, registry, block) {
    const { options } = block.about;
    this.inset = inset;
    this.block = block;
    const preset = { title: "", question: "", description: "", figure: "", given: options, options, sweep: null };
    this.registry = { ...registry, scenarios: { [OWN]: preset } };
    /** What the knobs were given. @type {Record<string, string>} */
    this.own = {};
    this.knobs = new Knobs(registry, (name, text) => this.give(text ? { [name]: text } : {}));
    this.notes = el("p", { class: "notes", role: "status" });
    this.code = el("div", {});
    this.back = el("button", { type: "button", on: { click: () => this.reset() } }, t("cellBack"));
    this.parts = [
      el("div", { class: "row" }, this.back, el("span", { class: "hint" }, t("cellHint"))), this.notes, this.knobs.root,
      el("details", {}, el("summary", {}, t("code")), this.code)];
    inset.player.start.enable((degrees) => this.startAt(degrees));
    this.show();
  }

  /** Say what the run on show has. */
  show() {
    const { registry, own } = this;
    const motion = /** @type {import("./player/motion.js").Motion} */ (this.inset.player.motion);
    const { options, warnings = [] } = motion.about;
    this.knobs.showRun(motion, own, OWN);
    this.notes.textContent = warningsText(warnings);
    this.code.replaceChildren(...codeBlocks([pythonLines, commandLine].map((lines) => lines(registry, options))));
    this.back.disabled = Object.keys(own).length === 0;
  }

  /**
   * Ask for the run with other values.
   * @param {Record<string, string>} changed
   */
  give(changed) {
    this.own = withOptions(this.registry, this.own, changed);
    void this.compute();
  }

  /**
   * Ask for the run that begins with the balls at rest at these angles.
   * @param {number[]} degrees
   */
  startAt(degrees) {
    const shown = this.inset.player.motion?.about.options ?? {};
    this.own = withStart(this.own, shown, degrees);
    void this.compute();
  }

  /** Show the run of the cell again. */
  reset() {
    this.own = {};
    this.inset.runner?.stop();
    this.inset.show(this.block);
    this.knobs.forget();
    this.show();
  }

  /** Compute what the knobs ask for, and show it. */
  async compute() {
    const { registry, own } = this;
    this.back.disabled = false;
    try {
      if (await this.inset.compute({ options: optionsOf(registry, { scenario: OWN, options: own }) })) this.show();
    } catch (error) {
      const words = inPagesWords(this.knobs.inWords(), /** @type {Error} */ (error));
      if (!this.knobs.error(...words)) this.inset.refuse(words[0]);
    }
  }
}

/**
 * Return the first law of a run that pages do not have, undefined where they have all.
 * @param {Registry} registry
 * @param {Record<string, any>} options of the run
 */
function lawBeyondPage({ systems, drives, contact_laws: laws }, { system, drive, contact = "exact" }) {
  const all = [...Object.keys(systems), ...Object.keys(drives), ...Object.keys(laws)];
  return [system, drive, contact].find((name) => !all.includes(name));
}

/**
 * Show a run in a cell; returns what takes it away again.
 * @param {{model: any, el: HTMLElement}} cell
 */
export async function render({ model, el: cell }) {
  const registry = await loadRegistry();
  const language = model.get("language");
  if (language) speakTable(registry, language, JSON.parse(model.get("texts")));
  const host = el("div", {});
  cell.append(host);
  // Some of the player's keys delete cells in notebooks.
  for (const name of ["keydown", "keypress", "keyup"])
    host.addEventListener(name, (event) => {
      if (isOwnKey(/** @type {KeyboardEvent} */ (event))) event.stopPropagation();
    });
  const inset = new EmbeddedPlayer(host);
  // Where one sees the balls while a slider moves.
  const below = el("div", { class: "controls" });
  inset.player.moreCurves.before(below);
  await inset.load();
  const show = () => {
    const { buffer, byteOffset, byteLength } = /** @type {DataView} */ (model.get("block"));
    const block = unpack(
      /** @type {ArrayBuffer} */ (buffer).slice(byteOffset, byteOffset + byteLength));
    inset.show(block);
    const law = lawBeyondPage(registry, block.about.options);
    inset.player.start.choose = null;
    below.replaceChildren(...(law ? [el("p", { class: "hint" }, t("cellBeyond", { name: law }))]
      : new Controls(inset, registry, block).parts));
  };
  model.on("change:block", show);
  show();
  return () => {
    model.off("change:block", show);
    inset.leave();
    host.remove();
  };
}
