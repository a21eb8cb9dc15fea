/** The few large knobs of a toy: plain names, and how often it shakes in two ways. */

import { t } from "../strings.js";
import { el } from "./dom.js";
import { Knob } from "./knob.js";
import { naturalFrequency, textIn } from "./option_texts.js";
import { short } from "./unit_text.js";

/** @typedef {import("../model/registry.js").Registry} Registry */
/**
 * What a toy is like, and what its knobs begin with, in SI units; `low` and `high` are the angles
 * of the walls.
 * @typedef {{length: number, mass: number, naturalFrequency: number, low?: number, high?: number,
 *   values: Record<string, any>}} ToyScale
 */

/** Names that need no physics. */
const NAMES = /** @type {Record<string, string>} */ ({
  drive_amplitude: "knobAmplitude", vertical_amplitude: "knobVertical",
  horizontal_amplitude: "knobHorizontal", drive_frequency: "knobFrequency", restitution: "knobRestitution",
  damping: "knobDamping", initial_angle: "knobAngle", initial_offset: "knobOffset",
  length: "knobLength", right_length: "knobLengthRight", left_length: "knobLengthLeft",
});
const AMPLITUDES = ["drive_amplitude", "vertical_amplitude", "horizontal_amplitude"];
const COUNT = 3;
/** What an amplitude means: half of the way from end to end. @type {Record<string, string>} */
const MEANINGS = { drive_amplitude: "upAndDown", vertical_amplitude: "upAndDown", horizontal_amplitude: "toEachSide" };
const DIGITS = 4;
// Beyond so many times what their sliders reach, these knobs refuse a slip of the keyboard.
const FARTHEST = 10;
const SLIPS = ["drive_amplitude", "drive_frequency"];

/**
 * Return the options that tell most about a toy, the first ones first, three where there are so many.
 * @param {Registry} registry
 * @param {Record<string, any>} options of a run, in SI units
 */
export function tellingOptions(registry, { system, drive, initial_offset: offset }) {
  const known = [...registry.systems[system].options, ...registry.drives[drive].options];
  const start = offset === undefined || offset === null ? "initial_angle" : "initial_offset";
  // Two angles are no single number.
  const first = registry.systems[system].angles === 2 ? [] : [start];
  const rest = registry.systems[system].contacts || drive === "fixed_pivot"
    ? [...first, "damping"] : ["damping", ...first];
  return [...AMPLITUDES, "drive_frequency", "restitution", ...rest, "length", "right_length",
    "left_length"].filter((name) => known.includes(name) || name === start).slice(0, COUNT);
}

/**
 * Return how far sliders go, for this toy: at least to what it begins with.
 * @param {ToyScale} toy
 * @returns {Record<string, [number, number]>}
 */
export function spansOf({ length, mass, naturalFrequency, low = -Math.PI, high = Math.PI, values }) {
  const beyond = (/** @type {string} */ name, /** @type {number} */ times) => times * (values[name] ?? 0);
  return {
    ...Object.fromEntries(AMPLITUDES.map((name) =>
      [name, [0, Math.max(0.25 * length, beyond(name, 1.5))]])),
    drive_frequency: [0, Math.max(5 * naturalFrequency, beyond("drive_frequency", 1.25))],
    damping: [0, Math.max(0.1 * naturalFrequency * mass * length, beyond("damping", 4))],
    initial_angle: [low, high],
    initial_offset: [0, high - low],
  };
}

export class Knobs {
  /**
   * @param {Registry} registry
   * @param {(name: string, text: string, value: number | null) => void} take called with the option,
   *   the text of its value, and the value in SI units, null for a text that is none
   */
  constructor(registry, take) {
    this.registry = registry;
    this.take = take;
    /** Keys that are shown beside the names. @type {Record<string, string[]>} */
    this.keys = {};
    /** @type {Record<string, Knob>} */
    this.all = {};
    this.root = el("div", { class: "knobs" });
    /** What the knobs on show are of. */
    this.subject = "";
    /** What the natural frequency is. */
    this.natural = el("p", { class: "hint" });
  }

  /**
   * Make a knob for each of these options.
   * @param {string[]} names
   */
  make(names) {
    this.all = Object.fromEntries(names.map((name) => [name, this.knob(name)]));
    this.root.hidden = false;
    this.root.replaceChildren(...Object.values(this.all).map(({ root }) => root));
    if (!names.includes("drive_frequency")) return;
    const ratio = this.knob("frequency_ratio");
    const { entry, note } = this.all.drive_frequency;
    // Both ways in one knob: two fields and one slider.
    entry.append(ratio.entry);
    note.after(ratio.note, this.natural);
    ratio.input.setAttribute("aria-label", ratio.option.label);
    this.all.frequency_ratio = ratio;
  }

  /**
   * Show the knobs that tell most about a run.
   * @param {import("../player/motion.js").Motion} motion
   * @param {Record<string, string>} own options that were given
   * @param {string} toy what the run is of: another one has sliders of its own
   */
  showRun({ about: { options }, balls: [{ length, mass }], low, high }, own, toy) {
    const names = tellingOptions(this.registry, options);
    const natural = naturalFrequency(options);
    const subject = JSON.stringify([toy, options.system, options.drive, names]);
    if (subject !== this.subject) {
      this.subject = subject;
      this.make(names);
      this.allow(spansOf({ length, mass, naturalFrequency: natural, low: low ?? undefined, high: high ?? undefined,
        values: options }));
    }
    this.explain(natural);
    for (const name of SLIPS) {
      const knob = this.all[name];
      if (knob?.span) knob.limits = [0, Number(short(FARTHEST * knob.span[1], 2))];
    }
    const { drive_frequency: frequency, frequency_ratio: ratio } = this.all;
    if (ratio) ratio.limits = [0, frequency.limits[1] / natural];
    for (const [name, knob] of Object.entries(this.all))
      knob.read(textIn(this.registry, own, options, name), own[name] !== undefined);
    this.error(null);
  }

  /** @param {string} name */
  knob(name) {
    const { options } = this.registry;
    const isRatio = name === "frequency_ratio";
    const option = /** @type {import("./option_texts.js").FieldOption} */ (
      options[name] ?? options[`right_${name}`]);
    const unit = isRatio ? { name: "1", size: 1, shown: t("timesNatural") }
      : name === "drive_frequency" ? { name: "Hz", size: 2 * Math.PI, shown: t("perSecond") } : undefined;
    return new Knob(name, isRatio ? { ...option, suggested: null } : option, {
      label: name in NAMES ? t(NAMES[name]) : option.label, unit, keys: this.keys[name],
      digits: DIGITS, meaning: MEANINGS[name], registry: this.registry, take: (text, value) => this.take(name, text, value) });
  }

  /**
   * Say what the natural frequency is, below the knob that counts in it.
   * @param {number} frequency [rad/s]
   * @param {string} [more] what is special there
   */
  explain(frequency, more = "") {
    this.natural.textContent = `${t("naturalIs", { rate: short(frequency / (2 * Math.PI), 3) })} ${more}`;
  }

  /**
   * Return a registry in which options have the names and units of their knobs on show.
   * @param {Registry} [registry] that has the others
   * @returns {Registry}
   */
  inWords(registry = this.registry) {
    const options = { ...registry.options };
    for (const [name, { label, shownAs }] of Object.entries(this.all))
      if (name in options) options[name] = { ...options[name], label, units: [shownAs] };
    return { ...registry, options };
  }

  /** Forget what was typed and refused. */
  forget() {
    for (const knob of Object.values(this.all)) knob.forget();
  }

  /**
   * Say how far the sliders go.
   * @param {Record<string, [number, number]>} spans
   */
  allow(spans) {
    for (const [name, knob] of Object.entries(this.all)) if (spans[name]) knob.span = spans[name];
  }

  /**
   * Show why something was refused, beside its knob; returns whether it has one.
   * @param {string | null} text
   * @param {string | null} [field]
   */
  error(text, field = null) {
    for (const [name, knob] of Object.entries(this.all)) knob.error(name === field ? text : null);
    return field !== null && field in this.all;
  }
}
