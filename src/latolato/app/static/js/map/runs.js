/** The options of the run of one point of a map. */

/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {Record<string, any>} Options */

const SIDES = ["right", "left"];

/**
 * Return options with values of a map's axes put in, also of those that stand for others.
 * @param {Registry} registry
 * @param {Options} options in SI units
 * @param {Record<string, number>} values by the names of axes
 * @returns {Options}
 */
export function optionsAt(registry, options, values) {
  const result = { ...options };
  for (const [name, value] of Object.entries(values)) {
    const { sets } = registry.axes[name];
    if (sets === "initial_angle") {
      delete result.initial_angle;
      delete result.initial_offset;
    }
    const side = SIDES.findIndex((each) => name.endsWith(`_${each}`));
    const pair = side < 0 ? "" : name.slice(0, -SIDES[side].length - 1);
    if (registry.options[pair]?.for_each_ball) {
      result[pair] = [result[pair] ?? 0].flat();
      if (result[pair].length === 1) result[pair] = [result[pair][0], result[pair][0]];
      result[pair][side] = value;
    } else if (sets === name || sets === "initial_angle") result[name] = value;
  }
  const length = result.length ?? result.right_length;
  const { frequency_ratio: ratio, amplitude_ratio: amplitude, drive_acceleration_ratio: acceleration } = values;
  if (ratio !== undefined) result.drive_frequency = ratio * Math.sqrt(result.gravity / length);
  if (amplitude !== undefined) result.drive_amplitude = amplitude * length;
  if (acceleration !== undefined)
    result.drive_amplitude = (acceleration * result.gravity) / result.drive_frequency ** 2;
  return result;
}

/**
 * Return the options of the run of a cell.
 * @param {import("./question.js").Question} question
 * @param {number} cell
 */
export function optionsOfCell({ registry, options, plan, duration }, cell) {
  const { x, y } = plan;
  const width = x.values.length;
  /** @type {Options} */
  const base = { ...options, duration, tolerance: registry.sweep_tolerance };
  for (const name of ["times", "samples"]) delete base[name];
  // The kicks of a cell are those of its own random stream, unless an axis says which.
  if (base.noise_strength !== undefined && ![x.name, y.name].some((name) => /^noise_(seed|stream)$/.test(name)))
    base.noise_stream = (base.noise_stream ?? 0) + cell;
  return optionsAt(registry, base, { [x.name]: x.values[cell % width],
    [y.name]: y.values[Math.floor(cell / width)] });
}
