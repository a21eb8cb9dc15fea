/** The run that a point of a picture stands for: its motion, and the way to Play. */

import { el } from "./dom.js";
import { openLink } from "./links.js";
import { Runner } from "./model/client.js";
import { Motion } from "./motion.js";
import { Preview } from "./preview.js";
import { t } from "./strings.js";

/** @typedef {{scenario: string | null, options: Record<string, string>}} Asked */

export class PointRun {
  /**
   * @param {import("./main.js").Page} page
   * @param {(asked: Asked) => void} use called when the questions shall be about this point
   */
  constructor(page, use) {
    this.page = page;
    this.use = use;
    this.turn = 0;
    this.runner = new Runner(page.registry);
    /** @type {Preview | null} */
    this.preview = null;
    this.said = el("p", { role: "status" });
    this.actions = el("div", { class: "actions" });
    this.place = el("div", {});
    this.root = el("section", { class: "card point", hidden: true },
      el("h2", {}, t("pointTitle")), this.said, this.actions, this.place);
  }

  /**
   * Show the run of a point.
   * @param {Asked} asked
   * @param {string} words what the point stands for
   */
  async show(asked, words) {
    this.turn += 1;
    const { turn } = this;
    this.root.hidden = false;
    this.said.textContent = words;
    this.actions.replaceChildren(
      openLink(this.page, { view: "play", ...asked }, t("openCase")),
      el("button", { type: "button", on: { click: () => this.use(asked) } }, t("pointUse")));
    try {
      const block = await this.runner.compute(asked);
      if (turn !== this.turn) return;
      this.preview ??= new Preview();
      this.place.replaceChildren(this.preview.root);
      this.preview.show(new Motion(block));
      this.root.scrollIntoView({ block: "nearest" });
      this.root.dataset.runs = String(Number(this.root.dataset.runs ?? 0) + 1);
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (turn !== this.turn) return;
      this.rest();
      this.place.replaceChildren(el("p", { class: "error", role: "alert" }, error.message));
    }
  }

  /** Stop the clock. */
  rest() {
    this.preview?.rest();
  }
}
