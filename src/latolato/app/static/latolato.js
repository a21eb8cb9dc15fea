/**
 * latolato in JavaScript: driven and colliding pendula, computed by the same compiled code as in
 * Python. It runs in pages, in workers and in Node.js, without a build step.
 *
 *     import { simulate } from "./latolato.js";
 *     const run = await simulate({ system: "latolato", length: 1, mass: 0.8, radius: 0.1,
 *       drive: "harmonic", drive_amplitude: 0.2, drive_frequency: 6.26, initial_angle: 0.3,
 *       duration: 60 });
 *     console.log(run.contact_time, run.energy_residual);
 *
 * @module
 */

import { loadLayout } from "./js/kernels/load.js";
import { loadRegistry } from "./js/model/registry.js";
import { specify } from "./js/model/case.js";
import { say } from "./js/model/rules.js";
import { run } from "./js/model/simulate.js";

export { InputError } from "./js/model/rules.js";

/**
 * A run. Angles, velocities and energies are arrays over `time`; of a `ballpair` they are lists of
 * two, right then left. The ledger (`drive_work`, `damping_loss`, `impact_loss`, `capture_loss`) is
 * per ball for one angle and the sum of both balls for a `ballpair`. On strings there are more:
 * `distance`, `radial_velocity` and `slack` over time, `retension_loss` and others.
 *
 * @typedef {object} RunData
 * @property {Float64Array} time [s]
 * @property {Float64Array | Float64Array[]} angle [rad]
 * @property {Float64Array | Float64Array[]} angular_velocity [rad/s]
 * @property {Float64Array} contact_time [s]
 * @property {string[]} contact_kind bottom, top, rest, release, slack or taut
 * @property {Float64Array | Float64Array[]} angular_velocity_before a contact [rad/s]
 * @property {Float64Array | Float64Array[]} angular_velocity_after a contact [rad/s]
 * @property {Float64Array} drive_work [J]
 * @property {Float64Array} damping_loss [J]
 * @property {Float64Array} impact_loss [J]
 * @property {Float64Array} capture_loss [J]
 * @property {number} energy_residual the largest error of the closed energy ledger [J]
 * @property {string} status "complete", or why the run ended before
 * @property {string[]} warnings
 * @property {Record<string, any>} parameters what was run, in SI units
 * @property {Record<string, string>} units by the names of the columns
 */

/**
 * Return the motion of a system.
 *
 * @param {Record<string, any>} parameters numbers in SI units, or texts with units such as
 *   "24.5 cm", by the names of the command line (`latolato simulate --help`) with underscores;
 *   `scenario` names a preset to begin with
 * @returns {Promise<RunData & Record<string, any>>}
 * @throws {InputError} for bad input, in the sentence that Python says
 */
export async function simulate({ scenario = null, ...options }) {
  const [registry, layout] = await Promise.all([loadRegistry(), loadLayout()]);
  const result = run(await specify(registry, { scenario, options }));
  const { contacts, columns, case: { system, options: parameters } } = result;
  /** @type {(rows: Float64Array[]) => Float64Array | Float64Array[]} */
  const each = (rows) => (rows.length === 1 ? rows[0] : rows);
  const arrays = Object.fromEntries(Object.entries(columns).map(([name, rows]) => [name, each(rows)]));
  const names = ["time", "contact_time", "angular_velocity_before", "angular_velocity_after",
    "energy_residual", ...Object.keys(result.pulls), ...Object.keys(contacts.others), ...Object.keys(columns)];
  return /** @type {any} */ ({
    time: result.time, ...arrays,
    contact_time: contacts.time,
    contact_kind: Array.from(contacts.kind, (kind) => layout.contact_kinds[kind]),
    angular_velocity_before: each(contacts.before), angular_velocity_after: each(contacts.after),
    ...Object.fromEntries(Object.entries(contacts.others).map(([name, rows]) => [name, each(rows)])),
    energy_residual: result.energyResidual, status: say(result.status),
    warnings: result.warnings.map((each) => say(each)),
    step: result.step, step_halvings: result.halvings, grazing_contacts: result.grazes,
    ...Object.fromEntries(Object.entries(result.pulls).map(([name, values]) => [name, single(values)])),
    natural_frequency: system.naturalFrequency, parameters,
    units: Object.fromEntries(names.map((name) => [name, registry.quantities[name].unit])),
  });
}

/** @type {(numbers: number[]) => number | number[]} */
const single = (numbers) => (numbers.length === 1 ? numbers[0] : numbers);
