/** The menu from which the run on show is stored: numbers, picture, animation, scenario. */

import { columnsTable, contactsTable, tomlOf } from "../model/run_files.js";
import { el, notify, saveFile } from "../page/dom.js";
import { fileOf, JobLine } from "../page/jobs.js";
import { Runner } from "../player/runner.js";
import { speedMenu } from "../player/clock.js";
import { t } from "../strings.js";

// What the page writes by itself, and what the installed program writes.
const OWN = ["csv", "contacts.csv", "toml"];
const OF_PROGRAM = ["nc", "png", "svg", "mp4"];
// What no parameters make again is stored as it is.
const OF_PLAYED = ["csv", "contacts.csv"];
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
    this.job = new JobLine();
    const [label, speed] = speedMenu(FASTEST);
    this.speed = speed;
    const { server } = page.registry;
    /** @type {[string, HTMLElement][]} */
    this.entries = [...OWN, ...(server ? OF_PROGRAM : [])].map((kind) => [kind, el("li", {},
      el("button", { type: "button", class: "plain link", on: { click: () => void this.store(kind) } }, t(`file_${kind}`)),
      el("span", { class: "soft" }, t(`fileHint_${kind}`), ...(kind === "mp4" ? [". ", label, " ", speed] : [])))]);
    root.addEventListener("keydown", (event) => {
      if (event.key === "Escape") root.open = false;
    });
    root.append(el("ul", {}, ...this.entries.map(([, item]) => item)),
      server ? this.job.root : el("p", { class: "hint" }, t("fileProgram")));
  }

  /**
   * Make the menu that of this run.
   * @param {{scenario: string | null, options: Record<string, any>}} request
   * @param {import("../page/block.js").Block} block the run on show
   * @param {boolean} isPlayed whether it was played by hand
   */
  show(request, block, isPlayed) {
    this.request = request;
    this.block = block;
    this.isPlayed = isPlayed;
    const touching = block.about.balls.length > 1;
    for (const [kind, item] of this.entries)
      item.hidden = (isPlayed && !OF_PLAYED.includes(kind)) || (kind === "contacts.csv" && !touching);
  }

  /**
   * Compute the run once more, with all its samples, and store it; what was played is stored as it is.
   * @param {string} kind
   */
  async store(kind) {
    const { registry } = this.page;
    const { request, block: shown, isPlayed } = this;
    if (!request || !shown) return;
    const { system, drive } = shown.about.options;
    const name = `latolato_${isPlayed ? "by_hand" : request.scenario ?? `${system}_${drive}`}.${kind}`;
    let file;
    if (OF_PROGRAM.includes(kind)) {
      const block = await this.job.run("ws/run/file", { kind, ...request, speed: Number(this.speed.value) });
      if (!block) return;
      file = fileOf(block, "file", block.about.type);
    } else {
      const block = isPlayed ? shown : await this.runner.compute(request, { mostSamples: MOST_SAMPLES });
      const text = kind === "toml" ? tomlOf(registry, block, name)
        : kind === "csv" ? columnsTable(registry, block) : contactsTable(registry, block);
      file = new Blob([text], { type: kind === "toml" ? "application/toml" : "text/csv" });
    }
    saveFile(file, name);
    notify(t("stored", { name }));
  }

  /** Cancel a file that is being made. */
  stop() {
    this.job.stop();
  }
}
