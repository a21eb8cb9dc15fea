/** What stands above a map: stop, zoom, move, and how far it is. */

import { el } from "../page/dom.js";
import { t } from "../strings.js";
import { scale } from "./travel.js";

const STATES = { busy: "stop", stopped: "mapGoOn", coarse: "mapFiner", done: "mapAgain" };

export class Toolbar {
  /** @param {import("./view.js").MapView} view */
  constructor(view) {
    const button = (/** @type {string} */ name, /** @type {() => void} */ action, text = t(name)) =>
      el("button", { type: "button", title: t(name), "aria-label": t(name),
        on: { click: action } }, text);
    this.panning = false;
    /** @type {keyof typeof STATES} */
    this.now = "done";
    this.stop = button("stop", () => view.stopOrGo());
    this.pan = button("mapPan", () => {
      this.panning = !this.panning;
      this.pan.setAttribute("aria-pressed", String(this.panning));
    });
    this.pan.setAttribute("aria-pressed", "false");
    this.progress = el("progress", { max: 1, value: 0, "aria-label": t("mapProgress") });
    this.text = el("span", { class: "soft progress-text", role: "status" });
    this.root = el("div", { class: "row map-bar" }, this.stop,
      button("mapIn", () => scale(view, 0.5), "+"),
      button("mapOut", () => scale(view, 2), "−"), this.pan,
      this.progress, this.text);
  }

  /**
   * Show what there is to do: a stored map has its points and no others.
   * @param {boolean} stored
   */
  show(stored) {
    for (const part of this.root.children)
      if (part !== this.text) /** @type {HTMLElement} */ (part).hidden = stored;
  }

  /**
   * Say how far the map is.
   * @param {string} text
   * @param {number | null} [share] null leaves the bar as it is
   */
  showProgress(text, share = null) {
    this.text.textContent = text;
    if (share !== null) this.progress.value = share;
  }

  /**
   * Show what the first button does: stop, go on, compute all points, or compute once more.
   * @param {keyof typeof STATES} state
   */
  state(state) {
    this.now = state;
    const name = t(STATES[state]);
    if (this.stop.textContent === name) return;
    this.stop.textContent = this.stop.title = name;
    this.stop.setAttribute("aria-label", name);
  }
}
