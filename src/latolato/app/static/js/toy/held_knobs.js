/** The knobs of a toy that a hand holds: their ranges, and the values that they refuse. */

import { spansOf } from "../page/knobs.js";

/** @typedef {import("./toy.js").Toy} Toy */

/** Keys of each control, as they are shown. */
export const KEYS = { drive_amplitude: ["↑", "↓"], drive_frequency: ["→", "←"], damping: ["D", "⇧D"],
  restitution: ["E", "⇧E"] };
// In this order, by what tells most.
const CONTROLS = ["drive_amplitude", "drive_frequency", "restitution", "damping"];

/**
 * Give a toy the knobs of its controls.
 * @param {import("../page/knobs.js").Knobs} knobs
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
