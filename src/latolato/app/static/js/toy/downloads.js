/** The menu from which the run on show is stored: numbers, picture, animation, scenario. */

import { columnsTable, contactsTable, tomlOf } from "../model/run_files.js";
import { el, notify, saveFile } from "../page/dom.js";
import { fileOf, JobLine } from "../page/jobs.js";
import { Runner } from "../player/runner.js";
import { speedMenu } from "../player/clock.js";
import { format } from "../page/state.js";
import { t } from "../strings.js";

// What the page writes by itself, and what the installed program writes.
const OWN = /** @type {const} */ (["csv", "contacts.csv", "toml"]);
const OF_PROGRAM = ["nc", "png", "svg"];
const FASTEST = 100;
// Samples of a run that is stored; as many as its default has, up to this number.
const MOST_SAMPLES = 200_000;

export class Downloads {
  /**
   * @param {import("../page/state.js").Page} page
   * @param {HTMLDetailsElement} root the drawer of the menu
   */
  constructor(page, root) {
    this.page = page;
    this.runner = new Runner(page.registry);
    this.request = { scenario: /** @type {string | null} */ (null), options: {} };
    /** What was played by hand, if that is on show. @type {import("../page/block.js").Block | null} */
    this.kept = null;
    const entry = (/** @type {string} */ kind, /** @type {HTMLElement} */ control) => el("li", {}, control,
      el("span", { class: "soft" }, ` ${t(`fileHint_${kind}`)}`));
    const own = OWN.map((kind) => ({ kind, item: entry(kind, el("button", { type: "button", class: "plain link",
      on: { click: () => void this.write(kind) } }, t(`file_${kind}`))) }));
    this.contacts = own[1].item;
    this.scenario = own[2].item;
    this.links = OF_PROGRAM.map((kind) => ({ kind, link: el("a", { download: "" }, t(`file_${kind}`)) }));
    const [label, speed] = speedMenu(FASTEST);
    this.speed = speed;
    this.job = new JobLine();
    this.make = el("button", { type: "button", on: { click: () => void this.animate() } },
      t("file_mp4"));
    root.addEventListener("keydown", (event) => {
      if (event.key === "Escape") root.open = false;
    });
    root.append(
      el("ul", {}, ...own.map(({ item }) => item),
        ...(page.registry.server ? this.links.map(({ kind, link }) => entry(kind, link)) : [])),
      ...(page.registry.server ? [this.ofProgram = el("div", {},
        el("div", { class: "row" }, this.make, label, speed),
        el("p", { class: "hint" }, t("fileHint_mp4")), this.job.root)]
        : [el("p", { class: "hint" }, t("fileProgram"))]));
  }

  /**
   * Make the menu that of this run.
   * @param {{scenario: string | null, options: Record<string, any>}} request
   * @param {boolean} touching whether balls of the run can touch
   * @param {import("../page/block.js").Block | null} kept what was played by hand, if that is on show: no
   *   parameters make it again, so it is stored as it is
   */
  show(request, touching, kept) {
    this.request = request;
    this.kept = kept;
    for (const part of [this.scenario, this.ofProgram, ...this.links.map(({ link }) => link.parentElement)])
      if (part) part.hidden = kept !== null;
    const query = format({ view: "toy", ...request, extra: {} });
    for (const { kind, link } of this.links) link.href = `download/run.${kind}${query}`;
    this.contacts.hidden = !touching;
  }

  /**
   * Compute the run once more, with all its samples, and store it; what was played is stored as it is.
   * @param {typeof OWN[number]} kind
   */
  async write(kind) {
    const { registry } = this.page;
    const { scenario } = this.request;
    const block = this.kept ?? await this.runner.compute(this.request, { mostSamples: MOST_SAMPLES });
    const { system, drive } = block.about.options;
    const name = `latolato_${this.kept ? "by_hand" : scenario ?? `${system}_${drive}`}.${kind}`;
    const text = kind === "toml" ? tomlOf(registry, block, name)
      : kind === "csv" ? columnsTable(registry, block) : contactsTable(registry, block);
    saveFile(new Blob([text], { type: kind === "toml" ? "application/toml" : "text/csv" }), name);
    notify(t("stored", { name }));
  }

  async animate() {
    this.make.disabled = true;
    const block = await this.job.run("ws/animation",
      { ...this.request, speed: Number(this.speed.value) });
    this.make.disabled = false;
    if (!block) return;
    saveFile(fileOf(block, "file", block.about.type), block.about.name);
    notify(t("stored", { name: block.about.name }));
  }

  /** Cancel an animation that is being made. */
  stop() {
    this.job.stop();
  }
}
