/** The run of one point of a map, beside it. */

import { askBlock } from "../shared/api.js";
import { el } from "../shared/dom.js";
import { textOf } from "../shared/laws.js";
import { Motion } from "../shared/motion.js";
import { Preview } from "../shared/preview.js";
import { waited } from "../shared/waiting.js";
import { t } from "../strings.js";

export class PointPanel {
  /**
   * @param {any} registry
   * @param {(options: Record<string, string>) => void} open called with the options of the run
   */
  constructor(registry, open) {
    this.registry = registry;
    /** @type {Record<string, any> | null} options of the run on show, in SI units */
    this.options = null;
    this.turn = 0;
    this.preview = new Preview();
    this.preview.root.hidden = true;
    this.title = el("p", { class: "hint", role: "status" }, t("mapPickHint"));
    this.button = el("button", { type: "button", disabled: true,
      on: { click: () => open(this.texts()) } }, t("mapOpenInPlay"));
    this.root = el("aside", { class: "card point" }, el("h2", {}, t("mapPoint")), this.title,
      this.preview.root, el("div", { class: "actions" }, this.button));
  }

  /** Return the options of the run as texts with units. */
  texts() {
    return Object.fromEntries(Object.entries(this.options ?? {}).map(([name, value]) =>
      [name, textOf(this.registry.options[name], value)]));
  }

  /**
   * Show the run of a point; an answer that comes after a newer question is left out.
   * @param {Record<string, any>} asked
   * @param {string} words what the point is
   */
  async run(asked, words) {
    this.turn += 1;
    const { turn } = this;
    this.title.textContent = t("computing");
    try {
      const block = await waited(this.title, askBlock("api/map/point", asked));
      if (turn !== this.turn) return;
      this.options = block.about.options;
      this.preview.root.hidden = false;
      this.preview.show(new Motion(block));
      this.title.textContent = words;
      this.button.disabled = false;
      this.root.dataset.runs = String(Number(this.root.dataset.runs ?? 0) + 1);
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (turn !== this.turn) return;
      this.title.textContent = error.message;
      this.button.disabled = true;
    }
  }
}
