/** Curves of theory and trials that are drawn over a map. */

import { askBlock } from "../api.js";

/** @typedef {import("./chart.js").Line & {name: string}} NamedLine */
/** @typedef {{lines: NamedLine[], trials: import("./chart.js").Trials | null, outside: number,
 *   notes: Record<string, string>}} Over */

const LINES = ["tongue", "lift_off"];

/**
 * Return what is drawn over a map, and why something is not.
 * @param {Record<string, any>} asked
 * @returns {Promise<Over>}
 */
export async function askOver(asked) {
  const { about, arrays } = await askBlock("/api/map/overlays", asked);
  return {
    lines: LINES.filter((name) => `${name}_x` in arrays).map((name) => ({ name,
      xs: arrays[`${name}_x`], ys: arrays[`${name}_y`], dashed: name === "lift_off" })),
    trials: arrays.trial_x
      ? { xs: arrays.trial_x, ys: arrays.trial_y, kinds: arrays.trial_class } : null,
    outside: about.outside,
    notes: about.notes,
  };
}
