/** The menu from which the run on show is stored: numbers, picture, animation, scenario. */

import { el, freshId, tell } from "./dom.js";
import { fileOf, JobLine, saveFile } from "./jobs.js";
import { format } from "./state.js";
import { t } from "./strings.js";

const KINDS = ["csv", "contacts.csv", "nc", "png", "svg", "toml"];
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];

export class Downloads {
  constructor() {
    this.asked = { scenario: /** @type {string | null} */ (null), options: {} };
    this.links = KINDS.map((kind) =>
      ({ kind, link: el("a", { download: "" }, t(`file_${kind}`)) }));
    const id = freshId();
    this.speed = el("select", { id }, ...SPEEDS.map((s) =>
      el("option", { value: String(s), selected: s === 1 }, t("speedText", { speed: s }))));
    this.job = new JobLine();
    this.make = el("button", { type: "button", on: { click: () => void this.film() } },
      t("file_mp4"));
    this.root = el("details", { class: "card downloads", on: {
      keydown: (/** @type {KeyboardEvent} */ event) => {
        if (event.key === "Escape") this.root.open = false;
      } } },
      el("summary", {}, t("download")),
      el("ul", {}, ...this.links.map(({ kind, link }) =>
        el("li", {}, link, el("span", { class: "soft" }, ` ${t(`fileHint_${kind}`)}`)))),
      el("div", { class: "row" }, this.make, el("label", { for: id }, t("speed")), this.speed),
      el("p", { class: "hint" }, t("fileHint_mp4")),
      this.job.root);
  }

  /**
   * Return nothing; the menu is of this run from now on.
   * @param {{scenario: string | null, options: Record<string, any>}} asked
   * @param {boolean} touching whether balls of the run can touch
   */
  show(asked, touching) {
    this.asked = asked;
    const query = format({ view: "play", ...asked, extra: {} });
    for (const { kind, link } of this.links) {
      link.href = `download/run.${kind}${query}`;
      const item = /** @type {HTMLElement} */ (link.parentElement);
      if (kind === "contacts.csv") item.hidden = !touching;
    }
  }

  async film() {
    const given = { ...this.asked, speed: Number(this.speed.value) };
    this.make.disabled = true;
    const block = await this.job.run("ws/animation", given);
    this.make.disabled = false;
    if (!block) return;
    saveFile(fileOf(block, "file", block.about.type), block.about.name);
    tell(t("stored", { name: block.about.name }));
  }

  /** Cancel an animation that is being made. */
  stop() {
    this.job.stop();
  }
}
