/** Keys of a view, where no other element wants them, and the list of them. */

import { t } from "../strings.js";
import { el } from "./dom.js";

/**
 * What a key does, and the name of the text that says so.
 * @typedef {{text: string, act: (event: KeyboardEvent) => void}} KeyAction
 * @typedef {Record<string, KeyAction>} KeyActions by the name of the key
 */

// How keys are written whose names no keyboard shows.
const TYPED = /** @type {Record<string, string>} */ ({
  ArrowUp: "↑", ArrowDown: "↓", ArrowRight: "→", ArrowLeft: "←", Escape: "Esc", Enter: "Enter" });

/**
 * Do what a key stands for while the focus is inside of `root`; returns what ends that.
 * @param {HTMLElement | Document} root
 * @param {KeyActions} actions
 */
export function followKeys(root, actions) {
  const follow = (/** @type {Event} */ event) => {
    const pressed = /** @type {KeyboardEvent} */ (event);
    if (pressed.defaultPrevented || pressed.ctrlKey || pressed.metaKey || pressed.altKey) return;
    if (!Object.hasOwn(actions, pressed.key) || wants(pressed)) return;
    pressed.preventDefault();
    actions[pressed.key].act(pressed);
  };
  root.addEventListener("keydown", follow);
  return () => root.removeEventListener("keydown", follow);
}

/** Return whether the element that has the focus needs a key itself. */
function wants(/** @type {KeyboardEvent} */ event) {
  const target = /** @type {HTMLElement} */ (event.target);
  // What lies behind a dialog waits until that is closed.
  if (target.closest?.("dialog")) return true;
  switch (target.tagName) {
    case "SELECT":
    case "TEXTAREA":
      return true;
    case "INPUT": {
      const { type } = /** @type {HTMLInputElement} */ (target);
      if (type === "range") return event.key.startsWith("Arrow");
      return type !== "checkbox" || event.key === " ";
    }
    case "BUTTON":
    case "SUMMARY":
      return event.key === " " || event.key === "Enter";
    case "A":
      return event.key === "Enter";
    default:
      return false;
  }
}

/** A button that opens the list of all keys, made of the tables that bind them. */
export class KeyList {
  /** @param {() => {title: string, actions: KeyActions}[]} sections */
  constructor(sections) {
    this.sections = sections;
    this.rows = el("div", {});
    this.dialog = el("dialog", { class: "keys", "aria-label": t("keysHere"), on: {
      // A click beside the list closes it, as Escape does.
      click: (/** @type {Event} */ event) => {
        if (event.target === this.dialog) this.dialog.close();
      } } }, this.rows, el("button", { type: "button", on: { click: () => this.dialog.close() } }, t("close")));
    this.button = el("button", { type: "button", class: "plain", "aria-haspopup": "dialog",
      on: { click: () => this.open() } }, t("keys"), el("kbd", { "aria-hidden": "true" }, "?"));
    this.root = el("span", { class: "key-list" }, this.button, this.dialog);
  }

  open() {
    this.rows.replaceChildren(...this.sections().flatMap(({ title, actions }) => [
      el("h2", {}, title), el("dl", {}, ...keyRows(actions))]));
    this.dialog.showModal();
  }
}

/**
 * The keys with what they do, those together that do the same.
 * @param {KeyActions} actions
 */
function keyRows(actions) {
  const texts = [...new Set(Object.values(actions).map(({ text }) => text))];
  return texts.flatMap((text) => {
    const keys = Object.keys(actions).filter((key) => actions[key].text === text);
    return [el("dt", {}, ...keys.flatMap((key) => [el("kbd", {}, typed(key)), " "])),
      el("dd", {}, t(text))];
  });
}

/**
 * Return a key as keyboards show it; a capital letter is that letter with Shift.
 * @param {string} key
 */
function typed(key) {
  if (key === " ") return t("keyTyped_space");
  return TYPED[key] ?? (/^[A-Z]$/.test(key) ? `⇧ ${key}` : key.toUpperCase());
}
