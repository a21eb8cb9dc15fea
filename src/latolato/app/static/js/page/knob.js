/** A number that is slid or typed: a field with its unit and, where it has a span, a slider. */

import { splitQuantity } from "../model/units.js";
import { t } from "../strings.js";
import { el, freshId } from "./dom.js";
import { problemWith, readEntry, readQuantity, readRange, shownNumbers } from "./entry.js";
import { keep, recall } from "./preferences.js";
import { endsText, legible } from "./refusals.js";
import { besideUnit, localShort, short, shownUnit, symbolParts } from "./unit_text.js";

/** @typedef {import("./option_texts.js").FieldOption} FieldOption */
/** @typedef {import("./unit_text.js").Unit} Unit */
/** @typedef {import("../model/registry.js").Registry} Registry */
/**
 * What is heard of a change: the text with its unit, and the value in SI units, null for a text
 * that is no single quantity.
 * @typedef {(text: string, value: number | null) => void} Take
 */

// A scale that ends below so many times a power of ten has a hundredth of that for a step, else a tenth.
const COARSE = 4;
// A limit so many times the usual value only guards against slips: nobody means it.
const FARTHEST = 1000;
// Ends of sliders are round numbers up to so much of a step.
const ROUNDING = 1e-6;
// What the browser calls the unit that was chosen last for an option.
const UNIT = "latolato.unit.";
/** A key moves a knob by this share of its slider. */
const KEY_STEP = 0.01;

export class Knob {
  /**
   * @param {string} name of the option
   * @param {FieldOption} option
   * @param {{take: Take, label?: string, unit?: Unit & {shown: string}, keys?: string[],
   *   digits?: number, meaning?: string, isList?: boolean, mayBeEmpty?: boolean, registry: Pick<Registry, "units" | "prefixes">,
   *   unitChosen?: () => void}} how `unit` is the only one, with what it is called; `isList` whether
   *   several numbers may be given, `mayBeEmpty` whether none need be; `meaning` is a text that
   *   says the value in other words
   */
  constructor(name, option, { take, label = option.label, unit, keys = [], digits = 6,
    isList = option.several, mayBeEmpty = false, meaning = "", registry, unitChosen }) {
    this.name = name;
    this.option = option;
    this.label = label;
    this.take = take;
    this.only = unit;
    this.digits = digits;
    this.isList = isList;
    this.mayBeEmpty = mayBeEmpty;
    this.meaning = meaning;
    this.registry = registry;
    /** The unit that the first text came with, or that was chosen or typed here. */
    this.chosen = "";
    /** In SI units, null for a text that is no single quantity. @type {number | null} */
    this.value = null;
    /** Whether a text is typed and not yet taken. */
    this.isDraft = false;
    /** Whether what is typed was refused, and the text that was shown before. */
    this.isRefused = false;
    /** @type {string | null} */
    this.seen = null;
    /** What is taken, from slider, keys and keyboard. @type {[number, number]} */
    this.limits = [option.low ?? -Infinity, option.high ?? Infinity];
    /** How far the slider goes, and how far it goes now, held while it moves. */
    this.span = option.suggested;
    /** @type {[number, number]} */
    this.ends = this.span ?? [0, 1];
    const id = freshId();
    const [errorId, aboutId] = [freshId(), freshId()];
    this.input = el("input", { id, type: "text", inputmode: option.takesRange ? "text" : "decimal", autocomplete: "off",
      spellcheck: "false", placeholder: option.placeholder || null, "aria-describedby": option.isExplained ? `${errorId} ${aboutId}` : errorId, on: {
        input: () => { this.isDraft = true; }, change: () => this.type() } });
    const several = !unit && option.units.length > 1;
    this.units = several ? el("select", { "aria-label": t("unitOf", { name: label }), on: {
      change: () => {
        this.chosen = /** @type {HTMLSelectElement} */ (this.units).value;
        keep(UNIT + name, this.chosen);
        if (this.value !== null) this.show(this.value);
        unitChosen?.();
      } } }, ...option.units.map((each) => el("option", { value: each.name }, shownUnit(each.name))))
      : null;
    this.slider = this.span && el("input", { type: "range", min: "0", max: "1", step: "1",
      "aria-label": t("sliderOf", { name: label }), on: {
        input: () => this.slide(),
        change: () => { this.ends = this.reach(); },
      } });
    this.note = el("p", { class: "error", id: errorId, role: "alert", hidden: true });
    this.hint = meaning ? el("p", { class: "hint" }) : null;
    this.entry = el("span", { class: "entry" }, this.input, this.units
      ?? el("span", { class: "unit" }, unit?.shown ?? shownUnit(option.units[0]?.name ?? "")));
    this.root = el("div", { class: "field knob" },
      el("label", { for: id, title: option.description }, `${label} `, symbolOf(option),
        ...keys.map((key) => el("kbd", { "aria-hidden": "true" }, key))),
      this.entry, this.slider, this.hint, explanation(option, aboutId), this.note);
  }

  /** The unit on show. @returns {Unit} */
  get unit() {
    const { units } = this.option;
    const named = (/** @type {string | null} */ name) => units.find((u) => u.name === name);
    return this.only ?? named(this.chosen) ?? named(recall(UNIT + this.name)) ?? units[0]
      ?? { name: "", size: 1 };
  }

  /**
   * Return how far the slider goes: to the value if that lies outside.
   * @returns {[number, number]}
   */
  reach() {
    const [low, high] = this.span ?? [0, 1];
    return this.value === null ? [low, high]
      : [Math.min(low, this.value), Math.max(high, this.value)];
  }

  /** Return a text that is read as this value, in the unit on show. */
  textOf(/** @type {number} */ value) {
    return this.textIn(this.rounded(value));
  }

  /** Return a text of a number in the unit on show. */
  textIn(/** @type {number} */ number) {
    const { name } = this.unit;
    return `${short(number)} ${name === "1" ? "" : name}`.trim();
  }

  /** Return a value to four digits in the unit on show: a limit is rounded to what it allows. */
  rounded(/** @type {number} */ value) {
    const number = Number(short(value / this.unit.size, 4));
    const read = this.valueOf(this.textIn(number));
    if (read === null || this.reaches(read) || !this.reaches(value)) return number;
    const place = 10 ** (Math.floor(Math.log10(Math.abs(number))) - 3);
    return read > value ? number - place : number + place;
  }

  /**
   * Return a text as a value in SI units, null if it is no single quantity.
   * @param {string} text
   */
  valueOf(text) {
    const { value } = readQuantity(this.registry, text, this.option.unit);
    return Number.isNaN(value) ? null : value;
  }

  /** The unit on show, by the name that people read. @returns {Unit} */
  get shownAs() {
    const { name, size } = this.unit;
    return { name: this.only?.shown ?? name, size };
  }

  /** Return a value with its unit, as people read it. */
  wordsOf(/** @type {number} */ value) {
    return besideUnit(legible(short(this.rounded(value))), shownUnit(this.shownAs.name));
  }

  /** Whether a text is being typed that nobody has taken yet. */
  get isTyping() {
    return this.isDraft && isFocused(this.input);
  }

  /**
   * Show a value in SI units; a text that is being typed stays.
   * @param {number} value
   */
  show(value) {
    this.forget();
    this.value = value;
    if (this.units) this.units.value = this.unit.name;
    if (!this.isTyping) this.input.value = localShort(value / this.unit.size, this.digits);
    this.place();
  }

  /**
   * Show a text, unless another one is being typed.
   * @param {string | null} text null for none
   * @param {boolean} [isOwn] whether the user gave it
   */
  read(text, isOwn = false) {
    // What was refused stays with its error, whatever else changes, until there is another value.
    if (this.isRefused && text === this.seen) return;
    // Units of later texts come from elsewhere on the page: this field keeps its own.
    const isFirst = this.seen === null;
    this.seen = text;
    this.forget();
    const given = text ?? "";
    const { units } = this.option;
    const { number = "", unit = "" } = splitQuantity(given) ?? {};
    // A number of more digits than are shown was computed: nobody chose its unit.
    const isTyped = Number(short(Number(number), this.digits)) === Number(number);
    if (isFirst && !this.chosen && isOwn && isTyped && units.some((u) => u.name === unit)) this.chosen = unit;
    const isSingle = !/[,:]/.test(given);
    this.value = isSingle ? this.valueOf(given) : null;
    if (this.value !== null) {
      this.show(this.value);
      return;
    }
    if (this.units) this.units.value = this.unit.name;
    if (!this.isTyping) this.input.value = isSingle ? given
      : shownNumbers(given, { registry: this.registry, unit: this.option.unit, usual: this.unit });
    this.place();
  }

  /** Put the slider where the value is. */
  place() {
    if (this.hint) this.hint.textContent = this.value === null ? ""
      : t(this.meaning, { way: this.wordsOf(this.value) });
    if (!this.slider || this.value === null) return;
    if (!isFocused(this.slider)) this.ends = this.reach();
    const { step, first, count } = this.grid;
    this.slider.max = String(count);
    this.slider.value = String(Math.round(this.value / step) - first);
    this.slider.setAttribute("aria-valuetext", this.wordsOf(this.value));
  }

  /**
   * The positions of the slider: both ends, and between them the round numbers of the unit on show, so
   * that an arrow key goes from one to the next. `first` and `step` are those of the round numbers.
   */
  get grid() {
    const [low, high] = this.ends;
    const { size } = this.unit;
    const step = size * roundStep(Math.max(-low, high) / size || 1);
    const first = Math.floor(low / step + ROUNDING);
    return { low, high, step, first, count: Math.max(1, Math.ceil(high / step - ROUNDING) - first) };
  }

  slide() {
    const { low, high, step, first, count } = this.grid;
    const i = Number(/** @type {HTMLInputElement} */ (this.slider).value);
    this.give(i <= 0 ? low : i >= count ? high : (first + i) * step);
  }

  /**
   * Take a value as if it had been slid to, rounded to what is shown.
   * @param {number} value in SI units
   */
  give(value) {
    const [low, high] = this.limits;
    const within = (/** @type {number} */ number) => Math.min(Math.max(number, low), high);
    const text = this.textOf(within(value));
    this.show(within(this.valueOf(text) ?? value));
    this.take(text, this.value);
  }

  /** Take what was typed, in the unit on show where it names none, or say what is wrong with it. */
  type() {
    this.isDraft = false;
    const { option, isList, mayBeEmpty, registry, unit } = this;
    const { values, text, problem } = (option.takesRange ? readRange : readEntry)(this.input.value, { registry, usual: unit, unit: option.unit,
      shown: this.only?.shown, isList, mayBeEmpty,
      example: this.example });
    const wrong = problem ?? values.map((each) => this.problemWith(each)).find((each) => each) ?? null;
    const value = values.length === 1 ? values[0] : null;
    if (wrong === null && (value === null || this.reaches(value))) {
      this.forget();
      const { unit: typed = "" } = splitQuantity(text) ?? {};
      this.chosen = option.units.find(({ name }) => [name, shownUnit(name)].includes(typed))?.name ?? this.chosen;
      if (this.units) this.units.value = this.unit.name;
      if (value !== null) this.show(value);
      this.take(text, value);
    } else this.refuse(wrong, value);
  }

  /** The text of a number that would do, empty if none is known. */
  get example() {
    const value = [this.value, ...(this.span ?? []), this.option.usual].find((each) =>
      typeof each === "number" && this.reaches(each) && this.problemWith(each) === null);
    return value === undefined ? "" : this.wordsOf(value);
  }

  /** Return why the option cannot have a value, null if it can. */
  problemWith(/** @type {number} */ value) {
    return problemWith(this.name, this.option, { label: this.label, unit: this.shownAs }, value);
  }

  /** Return whether a value lies in the limits. */
  reaches(/** @type {number} */ value) {
    const [low, high] = this.limits;
    return value >= low && value <= high;
  }

  /**
   * Say why what was typed is not taken, and offer a value that is.
   * @param {string | null} problem null where it is beyond the limits
   * @param {number | null} value in SI units
   */
  refuse(problem, value) {
    this.isRefused = true;
    const [low, high] = this.limits;
    const isBeyond = value !== null && !this.reaches(value);
    const [nearest, own] = isBeyond && value < low ? [low, this.option.low] : [high, this.option.high];
    const ends = this.limits.map((end) => (Number.isFinite(end) ? { end: this.wordsOf(end), is_open: false } : null));
    // A limit of this field alone has a sentence of its own.
    const text = isBeyond && nearest !== own ? t("outOfRange", { name: this.label, ends: endsText(ends[0], ends[1]) }) : problem;
    this.error(text);
    const offer = value === null ? undefined : this.offerNear(isBeyond ? nearest : null);
    if (offer !== undefined)
      this.note.append(text?.endsWith(".") ? " " : ". ", el("button", { type: "button", on: { click: () => this.give(offer) } },
        t("takeNearest", { value: this.wordsOf(offer) })));
  }

  /**
   * Return what to offer in place of a value that is refused: the limit beyond which it lies, or the usual value or the
   * default where that limit is too far from them to be what anybody wants.
   * @param {number | null} limit
   */
  offerNear(limit) {
    const known = [this.option.usual, this.option.default];
    // Zero is of no size.
    const size = known.find((each) => typeof each === "number" && each !== 0) ?? Infinity;
    const isMeant = limit !== null && Math.abs(limit) <= FARTHEST * Math.abs(size);
    return [isMeant ? limit : null, ...known].find((each) =>
      typeof each === "number" && this.reaches(each) && this.problemWith(each) === null);
  }

  /** Forget what was refused. */
  forget() {
    if (!this.isRefused) return;
    this.isRefused = false;
    this.error(null);
  }

  /**
   * Move by one key press.
   * @param {number} direction
   */
  turn(direction) {
    const [low, high] = this.ends;
    this.give((this.value ?? low) + direction * KEY_STEP * (high - low));
  }

  /**
   * Show why the run of this value was refused; what is typed here and was refused says so already.
   * @param {string | null} text
   */
  error(text) {
    if (text === null && this.isRefused) return;
    this.note.hidden = text === null;
    this.note.textContent = text ?? "";
    this.input.setAttribute("aria-invalid", String(text !== null));
  }
}

/**
 * Return the symbol of an option, to stand after its name.
 * @param {{symbol: string}} option
 */
export function symbolOf({ symbol }) {
  const parts = symbolParts(symbol);
  return parts.length ? el("i", {}, ...parts.map(({ text, place }) =>
    (place === "line" ? text : el(place, {}, text)))) : "";
}

/**
 * Return what an option means, to stand below its field where it is shown.
 * @param {FieldOption} option
 * @param {string} id
 */
export function explanation({ isExplained, description }, id) {
  return isExplained ? el("p", { class: "hint", id }, description) : null;
}

/**
 * Return the distance of the round numbers on a slider: forty to four hundred go to its farther end.
 * @param {number} farthest end, in the unit on show
 */
export function roundStep(farthest) {
  const power = Math.floor(Math.log10(farthest));
  return 10 ** (farthest < COARSE * 10 ** power ? power - 2 : power - 1);
}

/** Return whether an element has the focus, also inside of a root of its own. */
function isFocused(/** @type {Element} */ element) {
  return /** @type {Document | ShadowRoot} */ (element.getRootNode()).activeElement === element;
}
