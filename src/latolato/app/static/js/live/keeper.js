/** The recording of a live motion: its button, and the recordings that the browser keeps. */

import { el, freshId } from "../shared/dom.js";
import { saveFile } from "../shared/jobs.js";
import { openState, textsOf } from "../shared/links.js";
import { MOST_BYTES, MOST_KEPT, shelf } from "../shared/storage.js";
import { columnsTable, contactsTable } from "../model/files.js";
import { t } from "../strings.js";
import { fileText, readFile } from "./file.js";

/** @typedef {import("../main.js").Page} Page */
/** @typedef {import("../shared/block.js").Block} Block */
/** @typedef {import("../shared/storage.js").Entry} Entry */

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
    /** @type {Entry[]} */
    this.entries = [];
    this.button = el("button", { type: "button", "aria-pressed": "false", class: "record", on: {
      click: () => this.toggle() } });
    this.text = el("p", { role: "status" });
    this.select = el("select", { id: freshId() });
    this.actions = this.makeActions();
    this.input = el("input", { type: "file", accept: ".json,application/json", hidden: true,
      "aria-label": t("recordingOpen"), on: { change: () => void this.read() } });
    this.count = el("summary", {});
    this.list = el("details", {}, this.count, this.actions, el("div", { class: "actions" },
      button(t("recordingOpen"), () => this.input.click()), this.input));
    this.result = el("div", { class: "recorded none" }, this.text, this.list);
    this.show();
    // The toy comes first.
    setTimeout(() => void this.refresh());
  }

  /** Return the list of recordings, and what can be done with the one that is chosen there. */
  makeActions() {
    const table = (/** @type {string} */ kind, /** @type {typeof columnsTable} */ make) =>
      button(t(`file_${kind}`), () => void this.use((_, block) => saveFile(
        new Blob([make(this.page.registry, block)], { type: "text/csv" }), `live.${kind}`)));
    return el("div", { class: "actions" },
      el("label", { for: this.select.id }, t("recording")), this.select,
      button(t("openInPlay"), () => void this.use((entry) => this.open(entry)), "play"),
      button(t("recordingSave"), () => void this.use((entry, block) => this.save(entry, block))),
      table("csv", columnsTable), table("contacts.csv", contactsTable),
      button(t("recordingDelete"), () => void this.remove()));
  }

  toggle() {
    if (this.running) this.finish();
    else if (this.toy()) {
      this.running = true;
      this.text.textContent = "";
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

  /** End the recording, if there is one, and keep it. */
  finish() {
    const recording = this.toy()?.finish();
    this.running = false;
    this.show();
    if (!recording) return;
    const { registry } = this.page;
    const again = recording.again();
    const block = recording.block(again);
    const { duration } = recording;
    const options = recording.isRun(again) ? textsOf(registry, recording.options()) : null;
    void this.keep({ created: Date.now(), duration, options }, block,
      [t("recorded", { time: duration.toFixed(1) }), block.about.note]);
  }

  /**
   * Keep a recording, and say what became of it.
   * @param {Omit<Entry, "id" | "bytes">} about
   * @param {Block} block
   * @param {string[]} texts what to say first
   */
  async keep(about, block, texts) {
    const { entry, isKept, gone } = await shelf.put(about, block);
    if (!isKept) texts.push(t("recordingUnkept"));
    if (gone) texts.push(t("recordingsFull", { count: MOST_KEPT, size: MOST_BYTES / 1e6 }));
    this.text.textContent = texts.join(" ");
    await this.refresh(entry.id);
    this.list.open = true;
  }

  /**
   * List what the browser keeps.
   * @param {string} [chosen] id of the one to choose
   */
  async refresh(chosen = this.select.value) {
    this.entries = await shelf.list();
    const { lang } = document.documentElement;
    this.select.replaceChildren(...this.entries.map(({ id, created, duration }) =>
      el("option", { value: id, selected: id === chosen }, t("recordingName", {
        date: new Date(created).toLocaleString(lang, { dateStyle: "medium", timeStyle: "medium" }),
        time: duration.toFixed(1) }))));
    this.count.textContent = t("recordings", { count: this.entries.length });
    this.actions.hidden = this.entries.length === 0;
    this.result.classList.toggle("none", this.actions.hidden);
  }

  /**
   * Do something with the chosen recording.
   * @param {(entry: Entry, block: Block) => void} act
   */
  async use(act) {
    const entry = this.entries.find(({ id }) => id === this.select.value);
    if (!entry) return;
    const block = await shelf.block(entry.id);
    if (block) act(entry, block);
    else {
      this.text.textContent = t("recordingGone");
      await this.refresh();
    }
  }

  /**
   * Show a recording in Play: by its parameters if they make it again, else as it was kept.
   * @param {Entry} entry
   */
  open({ id, options }) {
    const { store } = this.page;
    if (options && new URLSearchParams(options).toString().length < LONGEST_ADDRESS) {
      openState(this.page, { view: "play", scenario: null, options });
      return;
    }
    store.set({ view: "play", extra: { ...store.state.extra, "play.recording": id } }, "view");
  }

  /**
   * @param {Entry} entry
   * @param {Block} block
   */
  save(entry, block) {
    const date = new Date(entry.created).toISOString().slice(0, 19).replaceAll(":", "-");
    saveFile(new Blob([fileText(this.page.registry, entry, block)], { type: "application/json" }),
      `latolato ${date}.json`);
  }

  async remove() {
    await shelf.remove(this.select.value);
    this.text.textContent = t("recordingDeleted");
    await this.refresh();
  }

  /** Keep the recording of the file that was chosen. */
  async read() {
    const file = this.input.files?.[0];
    this.input.value = ""; // so that the same file can be chosen again
    if (!file) return;
    try {
      const { about, block } = readFile(this.page.registry, await file.text());
      await this.keep(about, block, [t("recordingOpened", { name: file.name })]);
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      this.text.textContent = t("recordingRefused", { name: file.name, text: error.message });
    }
  }
}

/**
 * @param {string} text
 * @param {() => void} click
 * @param {string} [kind] a class
 */
function button(text, click, kind) {
  return el("button", { type: "button", class: kind, on: { click } }, text);
}
