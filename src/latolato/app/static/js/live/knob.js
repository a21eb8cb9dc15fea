/** One control of a live toy: a slider, a field with a unit, and keys. */

import { el, freshId } from "../shared/dom.js";
import { short, shownUnit, symbolParts, toSi } from "../shared/units.js";
import { t } from "../strings.js";

/** @typedef {import("../shared/form.js").Option} Option */

const STEPS = 200;
/** Keys of each control, as they are shown. */
export const KEYS = /** @type {Record<string, string[]>} */ ({
  drive_amplitude: ["↑", "↓"], drive_frequency: ["→", "←"], damping: ["D", "⇧D"],
  restitution: ["E", "⇧E"],
});
/** A key moves a control by this share of its slider. */
const KEY_STEP = 0.01;

export class Knob {
  /**
   * @param {Option} option
   * @param {string[]} keys shown beside the name
   * @param {(value: number) => void} changed called with the value in SI units
   * @param {(text: string, actions?: import("../shared/messages.js").Action[]) => void} refused called
   *   with why a value cannot be taken and what can, or with an empty text when one was taken
   */
  constructor(option, keys, changed, refused) {
    this.option = option;
    this.changed = changed;
    this.refused = refused;
    this.unit = option.units[0] ?? { name: "", size: 1 };
    this.value = 0;
    /** What was taken as it was typed. */
    this.typed = NaN;
    this.isDraft = false;
    /** What a toy takes, and what the slider spans. */
    this.limits = [0, 1];
    this.span = [0, 1];
    const id = freshId();
    this.errorId = freshId();
    this.slider = el("input", { type: "range", min: "0", max: String(STEPS), step: "1",
      "aria-label": t("sliderOf", { name: option.label }), on: { input: () => {
        const [low, high] = this.span;
        this.give(low + (Number(this.slider.value) / STEPS) * (high - low));
      } } });
    this.input = el("input", { id, type: "text", inputmode: "decimal", autocomplete: "off",
      spellcheck: "false", "aria-describedby": this.errorId, on: {
        input: () => { this.isDraft = true; }, change: () => this.read() } });
    this.also = el("output", { class: "soft" });
    this.note = el("p", { class: "error", id: this.errorId, hidden: true });
    const symbol = symbolParts(option.symbol).map(({ text, place }) =>
      (place === "line" ? text : el(place, {}, text)));
    this.root = el("div", { class: "field knob" },
      el("label", { for: id, title: option.description }, option.label, " ", el("i", {}, ...symbol),
        ...keys.map((key) => el("kbd", { "aria-hidden": "true" }, key))),
      el("span", { class: "entry" }, this.also, this.input,
        el("span", { class: "unit" }, shownUnit(this.unit.name))),
      this.slider, this.note);
  }

  /**
   * Say what may be set.
   * @param {number[]} limits
   * @param {number} usual upper end of the slider
   */
  allow(limits, usual) {
    this.limits = limits;
    this.span = [limits[0], Math.min(limits[1], usual)];
  }

  /** @param {number} value in SI units */
  show(value) {
    this.value = value;
    if (value > this.span[1]) this.span[1] = Math.min(this.limits[1], 1.25 * value);
    if (document.activeElement !== this.slider) this.place();
    const unit = shownUnit(this.unit.name);
    const text = short(value / this.unit.size, 4);
    this.slider.setAttribute("aria-valuetext", `${text} ${unit}`.trim());
    const isTyped = this.isDraft || value === this.typed;
    if (document.activeElement !== this.input || !isTyped) this.input.value = text;
  }

  /** Put the slider where the value is. */
  place() {
    const [low, high] = this.span;
    this.slider.value = String(Math.round((STEPS * (this.value - low)) / (high - low || 1)));
  }

  /** @param {number} value */
  give(value) {
    const rounded = Number(short(value / this.unit.size, 4)) * this.unit.size;
    this.value = Math.min(Math.max(rounded, this.limits[0]), this.limits[1]);
    this.error(null);
    this.show(this.value);
    this.changed(this.value);
  }

  /** Take what was typed, if it lies within the limits. */
  read() {
    this.isDraft = false;
    const { units, unit } = this.option;
    const text = this.input.value.trim().replace(",", ".");
    const plain = /[a-z°]/i.test(text) ? text : `${text} ${this.unit.name}`;
    const value = toSi(plain, [...units, { name: unit, size: 1 }]);
    if (value === null || !Number.isFinite(value)) {
      this.error(t("noNumber", { text }));
      return;
    }
    const [low, high] = this.limits;
    if (value < low || value > high) {
      const ends = [low, high].map((v) => short(v / this.unit.size, 4));
      const [least, most] = ends.map((end) => `${end} ${shownUnit(this.unit.name)}`.trim());
      const about = t("outOfRange", { name: this.option.label, low: ends[0], high: most });
      this.error(about);
      this.refused(about, [{ label: t("takeNearest", { value: value < low ? least : most }),
        act: () => this.give(value) }]);
      return;
    }
    this.error(null);
    this.refused("");
    this.typed = value;
    this.show(value);
    this.changed(value);
  }

  /**
   * Move by one key press.
   * @param {number} direction
   */
  turn(direction) {
    this.give(this.value + direction * KEY_STEP * (this.span[1] - this.span[0]));
    this.place();
  }

  /** @param {string | null} text */
  error(text) {
    this.note.hidden = text === null;
    this.note.textContent = text ?? "";
    this.input.setAttribute("aria-invalid", String(text !== null));
  }
}
