/** Numbers of stories as readers see them. */

import { DEGREE, localShort } from "../page/unit_text.js";
import { t } from "../strings.js";

const DIGITS = 3;
/** Why a run has none of these numbers. @type {Record<string, string>} */
const NONE = { time_to_angle: "storyNever", top_time: "storyNever", response_period: "storyNever",
  swing_period: "storyNoSwing", shakes_per_swing: "storyNoShakes", growth_rate: "storyNoGrowth",
  drive_speed: "storyNoDrive", drive_acceleration_ratio: "storyNoDrive" };
/** How units are shown, and how large each is. @type {Record<string, [string, number]>} */
const SHOWN = { rad: ["°", DEGREE], m: [" mm", 1e-3], 1: ["", 1] };

/**
 * Return a quantity of a run in words, or why it has none.
 * @param {string} name
 * @param {number} value [SI]
 * @param {string} unit
 */
export function shownNumber(name, value, unit) {
  if (Number.isNaN(value)) return t(NONE[name]);
  return withUnit(value, unit, name === "final_angle" ? 2 * DIGITS : DIGITS);
}

/**
 * Return a value with its unit.
 * @param {number} value [SI]
 * @param {string} unit
 * @param {number} [digits]
 */
export function withUnit(value, unit, digits = DIGITS) {
  const [words, size] = unit === "1/s" ? [` ${t("perSecond")}`, 1] : SHOWN[unit] ?? [` ${unit}`, 1];
  return `${localShort(value / size, digits)}${words}`.replace("-", "−");
}
