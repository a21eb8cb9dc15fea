/** The parameters of a toy that a hand holds as options of the address. */

import { textOf } from "../page/option_texts.js";

/**
 * Return the options of the address with the present controls, and without what belongs to other
 * drives than its cosine.
 * @param {any} registry
 * @param {Record<string, string>} before
 * @param {string} system
 * @param {Record<string, number>} controls in SI units
 * @param {string} changed the control that was changed last
 * @returns {Record<string, string>}
 */
export function withControls(registry, before, system, controls, changed) {
  const kept = registry.drives.harmonic.options;
  const known = registry.systems[system].options;
  /** @type {Record<string, string>} */
  const options = { ...before, drive: "harmonic" };
  for (const ratio of ["frequency_ratio", "frequency_ratios", "frequency_ratio_final"])
    delete options[ratio];
  for (const law of Object.values(registry.drives))
    for (const name of /** @type {any} */ (law).options)
      if (!kept.includes(name)) delete options[name];
  for (const [name, value] of Object.entries(controls)) {
    const written = (/** @type {string} */ option) => textOf(registry, option, Number(value.toPrecision(8)));
    if (kept.includes(name) || known.includes(name)) options[name] = written(name);
    // Two free balls have one each; they may differ until this control is touched.
    else if (name === changed)
      for (const side of ["right", "left"]) options[`${side}_${name}`] = written(`${side}_${name}`);
  }
  return options;
}
