/** The run of one point of a map, beside it. */

import { Runner } from "../model/client.js";
import { inPagesWords } from "../model/words.js";
import { el } from "../shared/dom.js";
import { textsOf } from "../shared/links.js";
import { Motion } from "../shared/motion.js";
import { Preview } from "../shared/preview.js";
import { t } from "../strings.js";

// Beyond it, a run that is computed is announced.
const PATIENCE = 700; // ms

export class PointPanel {
  /**
   * @param {import("../model/registry.js").Registry} registry
   * @param {(options: Record<string, string>) => void} open called with the options of the run
   */
  constructor(registry, open) {
    this.registry = registry;
    /** @type {Record<string, any> | null} options of the run on show, in SI units */
    this.options = null;
    this.runner = new Runner(registry);
    this.preview = new Preview();
    this.preview.root.hidden = true;
    this.title = el("p", { class: "hint", role: "status" }, t("mapPickHint"));
    this.button = el("button", { type: "button", disabled: true,
      on: { click: () => open(textsOf(registry, this.options ?? {})) } }, t("mapOpenInPlay"));
    this.root = el("aside", { class: "card point" }, el("h2", {}, t("mapPoint")), this.title,
      this.preview.root, el("div", { class: "actions" }, this.button));
  }

  /**
   * Show the run of a point.
   * @param {() => Record<string, any>} optionsOf returns its options, or throws why it cannot run
   * @param {string} words what the point is
   */
  async run(optionsOf, words) {
    const waiting = setTimeout(() => { this.title.textContent = t("computing"); }, PATIENCE);
    try {
      const block = await this.runner.compute({ options: optionsOf() });
      this.options = block.about.options;
      this.preview.root.hidden = false;
      this.preview.show(new Motion(block));
      this.title.textContent = words;
      this.button.disabled = false;
      this.root.dataset.runs = String(Number(this.root.dataset.runs ?? 0) + 1);
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return;
      if (!(error instanceof Error)) throw error;
      [this.title.textContent] = inPagesWords(this.registry, error);
      this.button.disabled = true;
    } finally {
      clearTimeout(waiting);
    }
  }
}
