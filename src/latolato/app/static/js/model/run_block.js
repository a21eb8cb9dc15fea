/** A run as the views draw it: its columns and its metadata. */

import { tablesOf } from "./run_files.js";
import { commandLine, pythonLines } from "./run_code.js";
import { say } from "./rules.js";
import { LEDGER } from "./simulate.js";

/** @typedef {import("./simulate.js").Run} Run */
/** @typedef {import("./case.js").Case} Case */
/** @typedef {import("../page/block.js").Block} Block */

const SIDES = ["right", "left"];

/**
 * Return a run as a block.
 * @param {Run} run
 * @returns {Block}
 */
export function blockOf(run) {
  const { time, columns, contacts } = run;
  /** @type {Block} */
  const block = { about: aboutOf(run), arrays: {}, shapes: {} };
  const put = (/** @type {string} */ name, /** @type {Float64Array[]} */ rows) => {
    const [{ length }] = rows;
    const whole = rows.length === 1 ? rows[0] : new Float64Array(rows.length * length);
    if (rows.length > 1) rows.forEach((row, i) => whole.set(row, i * length));
    block.arrays[name] = whole;
    block.shapes[name] = [rows.length, length];
  };
  block.arrays.time = time;
  block.arrays.strobe = run.strobes;
  for (const [name, rows] of Object.entries(columns)) put(name, rows);
  block.arrays.contact_time = contacts.time;
  block.arrays.contact_kind = contacts.kind;
  put("angular_velocity_before", contacts.before);
  put("angular_velocity_after", contacts.after);
  for (const [name, rows] of Object.entries(contacts.others)) put(name, rows);
  for (const name of ["time", "strobe", "contact_time", "contact_kind"])
    block.shapes[name] = [block.arrays[name].length];
  return block;
}

/**
 * Return the metadata of a run; attributes are those of `latolato.simulate`.
 * @param {Run} run
 */
function aboutOf(run) {
  const { columns, warnings, case: each } = run;
  const { registry, system, kernels } = each;
  const options = resolvedOf(each);
  // Of a run that stopped early, the last one before it did.
  const last = (/** @type {string} */ name) => columns[name][0].findLast(Number.isFinite) ?? NaN;
  return {
    options, is_sinusoidal: registry.drives[each.drive.kind].sinusoidal,
    warnings, duration: each.duration, attributes: attributesOf(run, options),
    contact_kinds: kernels.layout.contact_kinds, balls: ballsOf(system),
    ledger: Object.fromEntries(LEDGER.filter((name) => name in columns).map((name) => [name, last(name)])),
    python: pythonLines(registry, options), command: commandLine(registry, options),
  };
}

/**
 * @param {Run} run
 * @param {Record<string, any>} options
 */
function attributesOf(run, options) {
  const { registry, system, duration, contact, tolerance, restSpeed, frame, contactLimit, angles,
    velocities } = run.case;
  const single = (/** @type {number[]} */ numbers) => (numbers.length === 1 ? numbers[0] : numbers);
  const whole = { ...options, initial_offset: null, initial_angle: single(angles), times: null, samples: null,
    initial_angular_velocity: single(velocities), duration, contact, tolerance, rest_speed: restSpeed, frame,
    contact_limit: contactLimit };
  const flat = Object.entries(registry.options).map(([name]) => [name, /** @type {any} */ (whole)[name]])
    .filter(([name, value]) => name !== "system" && name !== "drive" && value !== null && value !== undefined);
  return {
    title: `latolato run of ${system.kind}`, latolato_version: registry.version,
    system: options.system, drive: options.drive, ...Object.fromEntries(flat),
    natural_frequency: system.naturalFrequency,
    ...(!system.contacts ? {} : system.angles === 2 ? { contact_separation: system.low }
      : { contact_angle_low: system.low, contact_angle_high: system.high }),
    scenario: JSON.stringify(tablesOf(registry, whole)),
    energy_residual: run.energyResidual, status: say(run.status), step: run.step, step_halvings: run.halvings,
    grazing_contacts: run.grazes, contacts: run.contacts.time.length,
    ...Object.fromEntries(Object.entries(run.pulls).map(([name, values]) => [name, single(values)])),
  };
}

/**
 * Return all options of a case, in SI units, with those of its laws that have a default.
 * @param {Case} each
 */
export function resolvedOf({ registry, options, system, drive, noise }) {
  /** @type {Record<string, any>} */
  const resolved = { ...options, system: system.kind, drive: drive.kind };
  for (const [ratio, name] of Object.entries(registry.ratios)) {
    if (!(ratio in resolved)) continue;
    delete resolved[ratio];
    resolved[name] = drive.parameters[registry.options[name].path[0]];
  }
  const ofNoise = Object.keys(registry.options).filter((name) => registry.options[name].owner === "noise");
  const known = [...registry.systems[system.kind].options, ...registry.drives[drive.kind].options,
    ...(noise ? ofNoise : [])];
  for (const name of known) {
    resolved[name] ??= registry.options[name].default;
    if (registry.options[name].is_later && resolved[name] === registry.options[name].default)
      delete resolved[name];
  }
  return resolved;
}

/**
 * Return name, length, radius, mass, row of the columns and sign of the angle of each ball on show.
 * @param {import("./laws.js").System} system
 * @returns {import("../player/motion.js").MotionBall[]}
 */
export function ballsOf(system) {
  const names = system.contacts ? SIDES : ["ball"];
  const mirrored = system.balls.length < names.length;
  return names.map((name, i) => {
    const row = mirrored ? 0 : i;
    const { length, radius, mass } = system.balls[row];
    return { name, row, sign: mirrored && name === "left" ? -1 : 1, length, radius, mass };
  });
}
