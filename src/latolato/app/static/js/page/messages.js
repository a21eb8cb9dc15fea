/** Messages on the stage: what has happened to the run on show, and what can be done about it. */

import { t } from "../strings.js";
import { el, notify } from "./dom.js";

/** @typedef {{label: string, act: () => void}} MessageAction */

// A message without actions stays as long as it takes to read it, and fades.
const SHORTEST = 5000; // ms
const PER_LETTER = 70; // ms
const FADING = 400; // ms

/** Say that something cannot be loaded: what asks for it later calls this on an error. */
export function sayOffline() {
  notify(t("offline"));
}

export class Messages {
  constructor() {
    this.root = el("div", { class: "messages", role: "status", "aria-live": "polite" });
    /** @type {Map<string, HTMLElement>} by what they are about */
    this.shown = new Map();
  }

  /**
   * Show a message, in the place of an older one about the same; an empty text takes that away.
   * @param {string} about
   * @param {string} text
   * @param {{actions?: MessageAction[], stays?: boolean, isBad?: boolean}} [how] with actions, a message stays
   *   until it is answered or dismissed; `isBad` is for what was refused
   */
  show(about, text, { actions = [], stays = actions.length > 0, isBad = false } = {}) {
    const old = this.shown.get(about);
    if (!text) {
      this.drop(about);
      return;
    }
    // What is said once more is not announced once more.
    if (stays && !actions.length && old?.firstChild?.textContent === text) return;
    const button = (/** @type {string} */ label, /** @type {() => void} */ act, name = label) =>
      el("button", { type: "button", "aria-label": name, class: name === label ? "" : "plain", on: {
        click: () => {
          this.drop(about);
          act();
        } } }, label);
    const message = el("div", { class: isBad ? "message bad" : "message" }, el("p", {}, text),
      ...actions.map(({ label, act }) => button(label, act)),
      stays && button("×", () => {}, t("dismiss")));
    this.shown.set(about, message);
    if (old) old.replaceWith(message);
    else this.root.append(message);
    if (!stays) this.fade(about, message, Math.max(SHORTEST, PER_LETTER * text.length));
    const { top } = this.root.getBoundingClientRect();
    if (top < 0 || top > window.innerHeight) notify(text);
  }

  /**
   * Show a message until something else is chosen.
   * @param {string} about
   * @param {string} text
   * @param {import("./state.js").Store} store
   */
  showOfStep(about, text, store) {
    this.show(about, text, { stays: true });
    const { step } = store;
    const end = store.subscribe(() => {
      if (store.step === step) return;
      end();
      this.drop(about);
    });
  }

  /**
   * @param {string} about
   * @param {HTMLElement} message
   * @param {number} after in ms
   */
  fade(about, message, after) {
    setTimeout(() => message.classList.add("fading"), after);
    setTimeout(() => { if (this.shown.get(about) === message) this.drop(about); }, after + FADING);
  }

  /** @param {string} about */
  drop(about) {
    this.shown.get(about)?.remove();
    this.shown.delete(about);
  }

  /** Take all messages away. */
  clear() {
    for (const about of [...this.shown.keys()]) this.drop(about);
  }
}
