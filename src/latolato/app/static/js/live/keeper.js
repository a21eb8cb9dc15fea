/** The recording of a live motion: its button, and what becomes of it. */

import { unpack } from "../block.js";
import { ask } from "../api.js";
import { el, tell } from "../dom.js";
import { textOf } from "../laws.js";
import { t } from "../strings.js";

/** @typedef {import("../main.js").Page} Page */

// A longer address is not understood by every server.
const LONGEST_ADDRESS = 6000;

export class Keeper {
  /**
   * @param {Page} page
   * @param {(record: boolean) => void} send
   */
  constructor(page, send) {
    this.page = page;
    this.send = send;
    this.running = false;
    this.button = el("button", { type: "button", "aria-pressed": "false", class: "record", on: {
      click: () => this.toggle() } });
    this.result = el("div", { class: "recorded", role: "status" });
    this.show(-1);
  }

  toggle() {
    this.running = !this.running;
    if (this.running) this.result.replaceChildren();
    this.send(this.running);
    this.show(this.running ? 0 : -1);
  }

  /** Give up a recording whose server is gone. */
  lose() {
    this.running = false;
    this.show(-1);
    this.result.replaceChildren(el("p", {}, t("recordingLost")));
  }

  /** @param {number} seconds since the recording began; negative without one */
  show(seconds) {
    const label = this.running
      ? t("stopRecording", { time: Math.max(seconds, 0).toFixed(1) }) : t("record");
    if (this.button.textContent === label) return;
    this.button.textContent = label;
    this.button.setAttribute("aria-pressed", String(this.running));
  }

  /** @param {any} about what the server says of a finished recording */
  finish(about) {
    this.running = false;
    this.show(-1);
    const time = about.duration.toFixed(1);
    const note = about.reproduces ? "recordedExact"
      : about.by_hand ? "recordedHand" : "recordedChaos";
    const file = (/** @type {string} */ suffix, /** @type {string} */ name) =>
      el("a", { href: `api/recording/${about.name}.${suffix}`, download: `live.${suffix}` }, name);
    this.result.replaceChildren(
      el("p", {}, t("recorded", { time }), " ", t(note)),
      el("div", { class: "actions" },
        el("button", { type: "button", class: "play", on: { click: () => void this.open(about) } },
          t("openInPlay")),
        file("nc", "NetCDF"), file("csv", "CSV")));
  }

  /**
   * Show a recording in Play: by its parameters if they make it again, else as it was kept.
   * @param {any} about
   */
  async open(about) {
    const { store, registry } = this.page;
    /** @type {Record<string, string>} */
    const options = {};
    for (const [name, value] of Object.entries(about.options))
      if (registry.options[name] || name === "system" || name === "drive")
        options[name] = textOf(registry.options[name] ?? { unit: "" }, value);
    const length = new URLSearchParams(options).toString().length;
    if (about.reproduces && length < LONGEST_ADDRESS) {
      store.set({ view: "play", scenario: null, options }, "view");
      return;
    }
    try {
      const response = await ask(`api/recording/${about.name}.block`);
      const block = unpack(await response.arrayBuffer());
      this.page.recordings = { ...this.page.recordings, [about.name]: block };
      const extra = { ...store.state.extra, "play.recording": about.name };
      store.set({ view: "play", extra }, "view");
    } catch (error) {
      tell(error instanceof Error ? error.message : String(error));
    }
  }
}
