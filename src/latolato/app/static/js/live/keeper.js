/** The recording of a live motion: its button, and what becomes of it. */

import { el } from "../shared/dom.js";
import { saveFile } from "../shared/jobs.js";
import { textOf } from "../shared/laws.js";
import { openState } from "../shared/links.js";
import { columnsTable, contactsTable } from "../model/files.js";
import { t } from "../strings.js";
import { SAME } from "./recording.js";

/** @typedef {import("../main.js").Page} Page */
/** @typedef {import("./recording.js").Recording} Recording */

// A longer address is not understood by every server.
const LONGEST_ADDRESS = 6000;

export class Keeper {
  /**
   * @param {Page} page
   * @param {() => import("./toy.js").Toy | null} toy
   */
  constructor(page, toy) {
    this.page = page;
    this.toy = toy;
    this.running = false;
    this.kept = 0;
    this.button = el("button", { type: "button", "aria-pressed": "false", class: "record", on: {
      click: () => this.toggle() } });
    this.result = el("div", { class: "recorded", role: "status" });
    this.show();
  }

  toggle() {
    if (this.running) this.finish();
    else if (this.toy()) {
      this.running = true;
      this.result.replaceChildren();
      this.toy()?.record();
      this.show();
    }
  }

  /** Follow the recording, which ends by itself when it is as long as it may be. */
  show() {
    const recording = this.toy()?.recording;
    if (recording?.isFull) {
      this.finish();
      return;
    }
    const time = (recording?.duration ?? 0).toFixed(1);
    const label = this.running ? t("stopRecording", { time }) : t("record");
    if (this.button.textContent === label) return;
    this.button.textContent = label;
    this.button.setAttribute("aria-pressed", String(this.running));
  }

  /** End the recording, if there is one, and offer it. */
  finish() {
    const toy = this.toy();
    const recording = toy?.finish();
    this.running = false;
    this.show();
    if (!toy || !recording) return;
    const again = recording.again();
    const reproduces = !recording.byHand && recording.deviation(again) <= SAME;
    const note = reproduces ? "recordedExact" : recording.byHand ? "recordedHand" : "recordedChaos";
    const { registry } = this.page;
    const file = (/** @type {string} */ kind, /** @type {typeof columnsTable} */ table) =>
      el("button", { type: "button", on: { click: () => saveFile(
        new Blob([table(registry, recording.block(again))], { type: "text/csv" }), `live.${kind}`) } },
      t(`file_${kind}`));
    this.result.replaceChildren(
      el("p", {}, t("recorded", { time: recording.duration.toFixed(1) }), " ", t(note)),
      el("div", { class: "actions" },
        el("button", { type: "button", class: "play",
          on: { click: () => this.open(recording, again, reproduces) } }, t("openInPlay")),
        file("csv", columnsTable),
        toy.system.contacts && file("contacts.csv", contactsTable)));
  }

  /**
   * Show a recording in Play: by its parameters if they make it again, else as it was kept.
   * @param {Recording} recording
   * @param {import("../model/simulate.js").Run} again
   * @param {boolean} reproduces
   */
  open(recording, again, reproduces) {
    const { store, registry } = this.page;
    const options = Object.fromEntries(Object.entries(recording.options())
      .map(([name, value]) => [name, textOf(registry.options[name], value)]));
    if (reproduces && new URLSearchParams(options).toString().length < LONGEST_ADDRESS) {
      openState(this.page, { view: "play", scenario: null, options });
      return;
    }
    // This page alone has it, so an embedded one opens it itself.
    this.kept += 1;
    const name = String(this.kept);
    this.page.recordings = { ...this.page.recordings, [name]: recording.block(again) };
    store.set({ view: "play", extra: { ...store.state.extra, "play.recording": name } }, "view");
  }
}
