/** Numbers of stories, made of a run. */

import { loadKernels } from "../kernels/load.js";
import { computeMap, moduleOf } from "../kernels/map.js";
import { specify } from "../model/case.js";
import { fieldsOf, planarOption } from "../model/laws.js";
import { row } from "../page/block.js";
import { DEGREE } from "../page/unit_text.js";
import { range } from "../player/motion.js";

/** @typedef {import("../page/block.js").Block} Block */

// Samples from here on show how a motion has settled.
const LATE = 0.75;
// Up to this angle a swing grows as the small-angle equation does [rad].
const SMALL = 20 * DEGREE;

/** @param {ArrayLike<number>} values */
const largest = (values) => range(values)[1];

/** @param {ArrayLike<number>} values */
function sizes(values) {
  return Float64Array.from(values, Math.abs);
}

/**
 * Return the angles of the first ball.
 * @param {Block} block
 */
function first(block) {
  return row(block, "angle", 0);
}

/**
 * Return when contacts of some kinds happen.
 * @param {Block} block
 * @param {string[]} kinds
 */
function contacts({ arrays, about }, kinds) {
  return [...arrays.contact_time].filter((_, i) =>
    kinds.includes(about.contact_kinds[arrays.contact_kind[i]]));
}

/** @param {Block} block */
function lateAngle({ arrays, shapes }) {
  const { time, angle } = arrays;
  const start = LATE * time[time.length - 1];
  const count = shapes.angle[1];
  return largest(sizes(angle.filter((_, i) => time[i % count] >= start)));
}

/**
 * Return when the first ball first reaches an angle, linear between samples [s].
 * @param {Block} block
 * @param {number} angle
 */
function timeToAngle(block, angle) {
  const { time } = block.arrays;
  const size = sizes(first(block));
  const after = size.findIndex((value) => value >= angle);
  if (after <= 0) return after === 0 ? 0 : NaN;
  const share = (angle - size[after - 1]) / (size[after] - size[after - 1]);
  return time[after - 1] + share * (time[after] - time[after - 1]);
}

/**
 * Return the mean time from one passage upwards through zero to the next, in the second half [s].
 * @param {Block} block
 */
function swingPeriod(block) {
  const { time } = block.arrays;
  const angle = first(block);
  const start = 0.5 * time[time.length - 1];
  /** @type {number[]} */
  const passages = [];
  for (let i = 0; i + 1 < time.length; i += 1)
    if (time[i] >= start && angle[i] < 0 && angle[i + 1] >= 0)
      passages.push(time[i] - (angle[i] * (time[i + 1] - time[i])) / (angle[i + 1] - angle[i]));
  if (passages.length < 2) return NaN;
  return (passages[passages.length - 1] - passages[0]) / (passages.length - 1);
}

/**
 * Return the slope of the logarithm of the peaks up to the first that is not small, in the later
 * half of them [1/s]: what dies away has gone by then.
 * @param {Block} block
 */
function growthRate(block) {
  const { time } = block.arrays;
  const size = sizes(first(block));
  /** @type {number[]} */
  let peaks = [];
  for (let i = 1; i + 1 < size.length; i += 1)
    if (size[i] > size[i - 1] && size[i] >= size[i + 1]) {
      if (size[i] > SMALL) break;
      peaks.push(i);
    }
  peaks = peaks.slice(peaks.length >> 1);
  if (peaks.length < 2) return NaN;
  const mean = (/** @type {number[]} */ values) => values.reduce((sum, each) => sum + each, 0) / values.length;
  const [x, y] = [peaks.map((i) => time[i]), peaks.map((i) => Math.log(size[i]))];
  const [midX, midY] = [mean(x), mean(y)];
  return mean(x.map((each, i) => (each - midX) * (y[i] - midY))) / mean(x.map((each) => (each - midX) ** 2));
}

/**
 * Return the largest angular frequency of the drive [rad/s].
 * @param {Block} block
 */
function fastestDrive({ about: { options } }) {
  return options.drive_frequencies ? largest(options.drive_frequencies) : options.drive_frequency ?? NaN;
}

/** @param {Block} block */
function hasMovingPivot({ arrays }) {
  return [arrays.pivot_height, arrays.pivot_across].some((places) => {
    const [low, high] = range(places ?? [0]);
    return low < high;
  });
}

/** @param {Block} block */
function driveSpeed(block) {
  return (block.about.options.drive_amplitude ?? NaN) * fastestDrive(block);
}

/** @type {Record<string, (block: Block, angle: number) => number>} */
const QUANTITIES = {
  largest_angle: ({ arrays }) => largest(sizes(arrays.angle)),
  late_angle: lateAngle,
  final_angle: (block) => first(block)[first(block).length - 1],
  farthest_from_top: ({ arrays }) => largest(arrays.angle.map((angle) => Math.abs(Math.PI - Math.abs(angle)))),
  time_to_angle: timeToAngle,
  top_time: (block) => contacts(block, ["top"])[0] ?? NaN,
  contacts: (block) => contacts(block, ["bottom", "top"]).length,
  top_contacts: (block) => contacts(block, ["top"]).length,
  swing_period: swingPeriod,
  shakes_per_swing: (block) => (hasMovingPivot(block) ? (swingPeriod(block) * fastestDrive(block)) / (2 * Math.PI) : NaN),
  response_period: ({ about }) => about.response_period ?? NaN,
  growth_rate: growthRate,
  drive_speed: driveSpeed,
  drive_acceleration_ratio: (block) => (driveSpeed(block) * fastestDrive(block)) / block.about.options.gravity,
};

/**
 * Return a quantity of a run [SI], NaN where the run has none, as for what never happens.
 * @param {string} name
 * @param {Block} block
 * @param {number} [angle] for `time_to_angle`, which one [rad]
 */
export function quantity(name, block, angle = NaN) {
  return QUANTITIES[name](block, angle);
}

/**
 * Return a run with after how many drive periods it repeats, as a map shows it of its point.
 * @param {import("../model/registry.js").Registry} registry
 * @param {import("../model/options.js").OptionsRequest} request
 * @param {Block} block
 * @returns {Promise<Block>}
 */
export async function withPeriod(registry, request, block) {
  const { system, drive, noise, contact, clampStep, restSpeed, contactLimit, duration, angles, velocities,
    distances } = await specify(registry, request);
  if (!registry.drives[drive.kind].periodic) return block;
  const { angles: _, ...fields } = fieldsOf(system);
  const start = angles.flatMap((angle, i) => [[`initial_angle.${i}`, angle],
    [`initial_angular_velocity.${i}`, velocities[i]], [`initial_distance.${i}`, distances[i] ?? NaN]]);
  /** @type {any} */
  const { drive_frequency: frequency = 0 } = drive.parameters;
  const kind = { angles: /** @type {1 | 2} */ (system.angles), in_plane: planarOption(registry,
    { ...system, drive: drive.kind, ...drive.parameters }) !== null };
  const { values } = computeMap(await loadKernels(moduleOf(kind)), {
    ...kind, count: 1, drive: /** @type {any} */ (drive), noise: noise ?? undefined,
    parameters: { ...fields, ...Object.fromEntries(start), tolerance: registry.sweep_tolerance,
      rest_speed: restSpeed, step: clampStep, collides: Number(system.contacts && contact !== "none") },
    observables: [{ name: "response_period" }], contact: clampStep ? "clamp" : "exact",
    contact_limit: contactLimit, duration, period: (2 * Math.PI) / frequency });
  return { ...block, about: { ...block.about, response_period: values.response_period[0] } };
}
