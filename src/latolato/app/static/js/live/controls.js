/** The knobs of a live toy: their ranges, and the values that they refuse. */

import { Knobs, spansOf } from "../shared/knobs.js";

/** @typedef {import("./toy.js").Toy} Toy */

// Keys of each control, as they are shown.
const KEYS = { drive_amplitude: ["↑", "↓"], drive_frequency: ["→", "←"], damping: ["D", "⇧D"],
  restitution: ["E", "⇧E"] };
// In this order, by what tells most.
const CONTROLS = ["drive_amplitude", "drive_frequency", "restitution", "damping"];

/**
 * Return knobs that belong to no toy yet.
 * @param {import("../model/registry.js").Registry} registry
 * @param {(name: string, text: string, value: number | null) => void} take called with what was
 *   slid or typed
 */
export const makeKnobs = (registry, take) => new Knobs(registry, take, KEYS);

/**
 * Give a toy the knobs of its controls.
 * @param {Knobs} knobs
 * @param {Toy} toy
 */
export function fit(knobs, { controls, limits, system }) {
  const names = CONTROLS.filter((name) => name in controls);
  const { naturalFrequency, balls: [{ length, mass }] } = system;
  knobs.make(names);
  const spans = spansOf({ length, mass, naturalFrequency, values: controls });
  knobs.allow(Object.fromEntries(names.map((name) => {
    const [low, high] = spans[name] ?? limits[name];
    return [name, [low, Math.min(high, limits[name][1])]];
  })));
  for (const name of names) {
    knobs.all[name].limits = limits[name];
    knobs.all[name].show(controls[name]);
  }
  const { frequency_ratio: ratio } = knobs.all;
  if (ratio) ratio.limits = [0, limits.drive_frequency[1] / naturalFrequency];
}
