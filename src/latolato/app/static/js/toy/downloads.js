/** The menu from which the run on show is stored: numbers, picture, animation, scenario. */

import { columnsTable, contactsTable, tomlOf } from "../model/run_files.js";
import { el, notify, saveFile } from "../page/dom.js";
import { FileQueue, fileOf } from "../page/jobs.js";
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
    this.files = new FileQueue();
    const [label, speed] = speedMenu(FASTEST);
    this.speed = speed;
    const { server } = page.registry;
    /** @type {[string, HTMLElement][]} */
    this.entries = [...OWN, ...(server ? OF_PROGRAM : [])].map((kind) => [kind, el("li", {},
      el("button", { type: "button", class: "plain link", on: { click: () => void this.add(kind) } }, t(`file_${kind}`)),
      el("span", { class: "soft" }, t(`fileHint_${kind}`), ...(kind === "mp4" ? [". ", label, " ", speed] : [])))]);
    root.addEventListener("keydown", (event) => {
      if (event.key === "Escape") root.open = false;
    });
    root.append(el("ul", {}, ...this.entries.map(([, item]) => item)),
      server ? this.files.job.root : el("p", { class: "hint" }, t("fileProgram")));
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
   * Store the run that is on show now, as soon as the files asked for before are made.
   * @param {string} kind
   */
  add(kind) {
    const { request, block, isPlayed = false } = this;
    if (!request || !block) return;
    const speed = Number(this.speed.value);
    return this.files.add(t(`file_${kind}`), () => this.store({ kind, ...request, speed }, block, isPlayed));
  }

  /**
   * Compute a run once more, with all its samples, and store it; what was played is stored as it is.
   * @param {{kind: string, scenario: string | null, options: Record<string, any>, speed: number}} request
   * @param {import("../page/block.js").Block} shown
   * @param {boolean} isPlayed
   */
  async store(request, shown, isPlayed) {
    const { registry } = this.page;
    const { kind } = request;
    const { system, drive } = shown.about.options;
    const name = `latolato_${isPlayed ? "by_hand" : request.scenario ?? `${system}_${drive}`}.${kind}`;
    let file;
    if (OF_PROGRAM.includes(kind)) {
      const block = await this.files.job.run("ws/run/file", request);
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

  /** Cancel the files that are being made. */
  stop() {
    this.files.stop();
  }
}
