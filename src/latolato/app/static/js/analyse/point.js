/** The run that a point of a picture stands for: its motion, and the way to Play. */

import { el } from "../page/dom.js";
import { openLink } from "../page/links.js";
import { Motion } from "../player/motion.js";
import { Preview } from "../player/preview.js";
import { Runner } from "../player/runner.js";
import { t } from "../strings.js";

/** @typedef {{scenario: string | null, options: Record<string, string>}} PointRequest */

export class PointRun {
  /**
   * @param {import("../page/state.js").Page} page
   * @param {(request: PointRequest) => void} use called when the questions shall be about this point
   */
  constructor(page, use) {
    this.page = page;
    this.use = use;
    this.turn = 0;
    this.runner = new Runner(page.registry);
    /** @type {Preview | null} */
    this.preview = null;
    this.label = el("p", { role: "status" });
    this.actions = el("div", { class: "actions" });
    this.place = el("div", {});
    this.root = el("section", { class: "card point", hidden: true },
      el("h2", {}, t("onePoint")), this.label, this.actions, this.place);
  }

  /**
   * Show the run of a point.
   * @param {PointRequest} request
   * @param {string} words what the point stands for
   */
  async show(request, words) {
    this.turn += 1;
    const { turn } = this;
    this.root.hidden = false;
    this.label.textContent = words;
    this.actions.replaceChildren(
      openLink(this.page, { view: "toy", ...request }, t("openInToy")),
      el("button", { type: "button", on: { click: () => this.use(request) } }, t("pointUse")));
    try {
      const block = await this.runner.compute(request);
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
