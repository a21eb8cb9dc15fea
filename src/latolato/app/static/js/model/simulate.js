/** One run from its parameters to its columns, as `latolato.simulate`. */

import { begin, shake } from "../kernels/begin.js";
import { loadKernels } from "../kernels/load.js";
import { drawKicks } from "../kernels/noise.js";
import { integrate, observe } from "../kernels/run.js";
import { checkIncreasing, driveOf, fieldsOf, systemOf } from "./laws.js";
import { optionsOf, partsOf, withoutRatios } from "./options.js";
import { BeyondPageError, checkedNumber, general, InputError, suggest } from "./rules.js";

/** @typedef {import("../kernels/memory.js").Kernels} Kernels */
/** @typedef {import("./registry.js").Registry} Registry */
/** @typedef {import("./options.js").Request} Request */
/** @typedef {import("./laws.js").System} System */
/** @typedef {import("./laws.js").Drive} Drive */

/**
 * What is to be run, checked: see `specify`.
 * @typedef {{registry: Registry, kernels: Kernels, options: Record<string, any>, system: System,
 *   drive: Drive, contact: string, clampStep: number, tolerance: number, restSpeed: number,
 *   contactLimit: number, frame: string, angles: number[], velocities: number[],
 *   offset: number | null, times: Float64Array | null, duration: number, noise: Noise | null}} Case
 * @typedef {{noise_strength: number, noise_seed?: number, noise_stream?: number,
 *   noise_interval?: number}} Noise
 *
 * A run: columns over the instants, one for each ball of those quantities that balls have.
 * @typedef {{time: Float64Array, columns: Record<string, Float64Array[]>, strobes: Float64Array,
 *   contacts: {time: Float64Array, kind: Uint8Array, before: Float64Array[], after: Float64Array[]},
 *   status: string, energyResidual: number, step: number, halvings: number, grazes: number,
 *   compressionTime: number[], compressionFraction: number[], warnings: string[], case: Case}} Run
 */

const SAMPLES_PER_PERIOD = 100;
const MOST_DEFAULT_SAMPLES = 20_000_000;
const MOST_STEPS = 1e9;
// A start this close to a wall is on it [rad].
const ON_WALL = 1e-12;
export const LEDGER = ["drive_work", "damping_loss", "impact_loss", "capture_loss", "noise_work"];
// Of the samples: an angle and its velocity for each ball.
const PER_BALL = 2;
const MOST_STROBES = 20_000;
// Forms of stretches that have a phase: cosine, swept cosine, crank; see `physics.drives.stretch`.
const PHASED = [1, 2, 3];

/**
 * Return what a request asks for, checked.
 * @param {Registry} registry
 * @param {Request} request
 * @returns {Promise<Case>}
 */
export async function specify(registry, request) {
  const options = optionsOf(registry, request);
  const preset = registry.scenarios[request.scenario ?? ""];
  if (preset?.sweep)
    throw new InputError(`${request.scenario} is a sweep over ${Object.keys(preset.sweep.axes).join(", ")}, `
      + `not one run: use \`latolato sweep ${request.scenario}\`, or Scenario.sweep in Python`);
  const kind = String(options.system);
  if (!Object.hasOwn(registry.systems, kind))
    throw new InputError(`unknown system '${kind}': ${suggest(kind, Object.keys(registry.systems))}`);
  const drive = options.drive ?? "fixed_pivot";
  if (!registry.systems[kind].compiled) throw new BeyondPageError(`the {parameter} ${kind} is`, "system");
  if (!registry.drives[drive]?.compiled) throw new BeyondPageError(`the {parameter} ${drive} is`, "drive");
  const kernels = await loadKernels(registry.systems[kind].angles === 2 ? "two" : "one");
  const parts = partsOf(registry, options);
  const system = systemOf(registry, kernels, kind, parts.system);
  withoutRatios(registry, parts.drive, system.naturalFrequency);
  const moved = driveOf(registry, drive, parts.drive);
  const law = contactOf(registry, system, parts.run);
  const noise = noiseOf(registry, parts.noise);
  return { ...checkedRun(registry, kernels, options, system, moved, law, parts.run), noise };
}

/**
 * Return the random kicks of a run, null without any.
 * @param {Registry} registry
 * @param {Record<string, any>} noise
 */
function noiseOf(registry, noise) {
  if (!Object.keys(noise).length) return null;
  const strength = registry.options.noise_strength;
  if (noise.noise_strength === undefined)
    throw new InputError(`VelocityKicks needs '{parameter}' [${strength.unit}]`,
      { parameter: "noise_strength" });
  return /** @type {Noise} */ (Object.fromEntries(Object.entries(noise).map(([name, value]) =>
    [name, checkedNumber(registry.options[name], name, value)])));
}

/**
 * Return the contact law of a run and the fixed step that it takes, 0 for none.
 * @param {Registry} registry
 * @param {System} system
 * @param {Record<string, any>} run
 */
function contactOf(registry, system, run) {
  const laws = registry.contact_laws;
  const name = run.contact ?? registry.options.contact.default;
  if (!Object.hasOwn(laws, name))
    throw new InputError(`unknown contact law '${name}': ${suggest(String(name), Object.keys(laws))}`);
  if (!laws[name].compiled) throw new BeyondPageError(`the {parameter} law ${name} is`, "contact");
  const owners = (/** @type {string} */ option) =>
    Object.keys(laws).filter((law) => laws[law].options.includes(option));
  for (const option of Object.keys(run)) {
    if (!owners(option).length || owners(option).includes(name)) continue;
    const kinds = owners(option).join(" or ");
    throw new InputError(`belongs to contact ${kinds}, not to ${name}`,
      { parameter: option, wayOut: "leave it out or change the contact" });
  }
  const own = laws[name].options.map((option) => {
    const about = registry.options[option];
    return checkedNumber(about, option, run[option] ?? about.default);
  });
  if (!system.contacts && laws[name].options.length)
    throw new InputError(`{parameter} '${name}' is for balls that meet, and a `
      + `${registry.systems[system.kind].title} has none`, { parameter: "contact", wayOut: "leave it out" });
  if (!system.contacts) return { contact: "none", clampStep: 0 };
  if (name === "clamp" && system.angles === 2)
    throw new InputError("{parameter} 'clamp' exists for the mirror-symmetric LatoLato only",
      { parameter: "contact", wayOut: "use 'exact' for a BallPair" });
  return { contact: name, clampStep: name === "clamp" ? own[0] : 0 };
}

/**
 * @param {Registry} registry
 * @param {Kernels} kernels
 * @param {Record<string, any>} options
 * @param {System} system
 * @param {Drive} drive
 * @param {{contact: string, clampStep: number}} law
 * @param {Record<string, any>} run
 * @returns {Omit<Case, "noise">}
 */
function checkedRun(registry, kernels, options, system, drive, law, run) {
  const usual = (/** @type {string} */ name) => run[name] ?? registry.options[name].default;
  const number = (/** @type {string} */ name) => checkedNumber(registry.options[name], name, usual(name));
  const tolerance = number("tolerance");
  const restSpeed = number("rest_speed");
  const contactLimit = number("contact_limit");
  const frame = usual("frame");
  if (!["pivot", "both"].includes(frame))
    throw new InputError("must be 'pivot' or 'both'", { parameter: "frame", value: frame });
  const { times, duration } = instantsOf(registry, run);
  const meets = system.contacts && law.contact !== "none";
  const start = startOf(registry, system, meets, run);
  if (law.clampStep > duration)
    throw new InputError(
      `must not exceed the duration ${general(duration)} s, got ${general(law.clampStep)}`,
      { parameter: "clamp_step", wayOut: "a thousandth of a second is usual" });
  return { registry, kernels, options, system, drive, ...law, tolerance, restSpeed, contactLimit, frame,
    ...start, times, duration };
}

/**
 * Return the instants that are asked for, null for the usual ones, and the end of the run.
 * @param {Registry} registry
 * @param {Record<string, any>} run
 */
function instantsOf(registry, { times = null, samples = null, duration = null }) {
  const endOf = (/** @type {any} */ value) => checkedNumber(registry.options.duration, "duration", value);
  if (samples !== null) {
    checkedNumber(registry.options.samples, "samples", samples);
    if (times !== null)
      throw new InputError("give either times or {parameter}, got both", { parameter: "samples" });
    if (duration === null) throw new InputError("needs a duration", { parameter: "samples" });
    const end = endOf(duration);
    return { times: evenly(end, samples), duration: end };
  }
  if (times === null) {
    if (duration === null)
      throw new InputError("is needed: give the end of the run in s, or times", { parameter: "duration" });
    return { times: null, duration: endOf(duration) };
  }
  const parameter = "times";
  if (!Array.isArray(times) || !times.every((time) => typeof time === "number"))
    throw new InputError("must be a sequence of numbers in s", { parameter, value: times });
  if (!times.length) throw new InputError("must be a non-empty sequence, got shape (0,)", { parameter });
  const bad = times.findIndex((time) => !Number.isFinite(time));
  if (bad >= 0)
    throw new InputError(`must be finite, got ${general(times[bad], 17)} at position ${bad}`, { parameter });
  checkIncreasing(parameter, times);
  const last = times[times.length - 1];
  if (duration === null && last <= 0)
    throw new InputError(`must reach beyond 0 s, where a run begins, got ${general(last)} as the last`,
      { parameter, wayOut: "add a later instant or give duration" });
  const end = endOf(duration ?? last);
  if (times[0] < 0 || last > end)
    throw new InputError(`must lie in [0, duration = ${general(end)}] s, got `
      + `${general(times[0] < 0 ? times[0] : last)}`, { parameter });
  return { times: Float64Array.from(times), duration: end };
}

/**
 * Return evenly spaced instants from 0 to an end, the very ones of `numpy.linspace`.
 * @param {number} end
 * @param {number} count
 */
export function evenly(end, count) {
  const step = end / (count - 1);
  const times = Float64Array.from({ length: count }, (_, i) => i * step);
  times[count - 1] = end;
  return times;
}

/**
 * Return one number, or one for each ball.
 * @param {Registry} registry
 * @param {string} parameter
 * @param {any} value
 * @param {number} count
 * @returns {number[]}
 */
function numbersFor(registry, parameter, value, count) {
  const option = registry.options[parameter];
  const isList = Array.isArray(value);
  if (count === 1) {
    if (isList)
      throw new InputError(`must be one number in ${option.unit} for one angle`, { parameter, value });
    return [checkedNumber(option, parameter, value)];
  }
  const both = value === 0 ? [0, 0] : value;
  if (!Array.isArray(both) || both.length !== 2)
    throw new InputError("of a BallPair must be two numbers (right, left)", { parameter, value });
  return both.map((each, i) => checkedNumber(option, `${parameter}[${i}]`, each));
}

/**
 * Return how a run begins; the kernel moves a start that is close to a wall onto it.
 * @param {Registry} registry
 * @param {System} system
 * @param {boolean} meets whether there are walls
 * @param {Record<string, any>} run
 */
function startOf(registry, system, meets, run) {
  const { initial_angle: angle = null, initial_offset: offset = null } = run;
  const parameter = "initial_angle";
  if (angle === null && offset === null)
    throw new InputError("is needed [rad] (for a LatoLato initial_offset may stand instead)", { parameter });
  if (offset !== null) {
    if (system.kind !== "latolato")
      throw new InputError("counts from the low contact angle of a LatoLato",
        { parameter: "initial_offset", wayOut: "use initial_angle for other systems" });
    if (angle !== null)
      throw new InputError("give only one of {parameter} and initial_offset", { parameter });
    checkedNumber(registry.options.initial_offset, "initial_offset", offset);
  }
  const velocities = numbersFor(registry, "initial_angular_velocity",
    run.initial_angular_velocity ?? 0, system.angles);
  if (system.angles === 2 && !Array.isArray(angle))
    throw new InputError("of a BallPair must be two numbers (right, left)", { parameter, value: angle });
  const angles = numbersFor(registry, parameter, offset === null ? angle : system.low + offset,
    system.angles);
  const [gap, name] = system.angles === 2
    ? [angles[0] - angles[1], "the separation {parameter}[0] - {parameter}[1]"] : [angles[0], "{parameter}"];
  const { low, high } = system;
  if (meets && !(low - ON_WALL <= gap && gap <= high + ON_WALL))
    throw new InputError(
      `${name} must lie between the contact angles [${general(low, 9)}, ${general(high, 9)}] rad`,
      { parameter, value: gap, wayOut: "give one at which the balls do not overlap" });
  return { angles, velocities, offset };
}

/**
 * Return the fields of the kernel's record of a case.
 * @param {Case} each
 * @param {number} step 0 for the one that the tolerance asks for
 */
export function recordOf(each, step) {
  const { system } = each;
  const pair = (/** @type {number[]} */ numbers) => [numbers[0], numbers[1] ?? 0];
  return {
    ...fieldsOf(system), initial_angle: pair(each.angles), initial_angular_velocity: pair(each.velocities),
    // The step is that of the whole drive, however long the run is.
    duration: Infinity, tolerance: each.tolerance, rest_speed: each.restSpeed, step: each.clampStep || step,
    meets: Number(system.contacts && each.contact !== "none"), follows_ledger: 1,
    follows_tension: Number(!system.linear),
  };
}

/**
 * Return what comes of a case.
 * @param {Case} each
 * @param {{mostSamples?: number, mostSteps?: number}} [how] samples of a run whose instants were
 *   not asked for, and steps, at most
 * @returns {Run}
 */
export function run(each, { mostSamples = Infinity, mostSteps = MOST_STEPS } = {}) {
  const { kernels } = each;
  const first = kernels.take("f8", 0);
  try {
    return carried(each, mostSamples, mostSteps);
  } finally {
    kernels.release(first);
  }
}

/**
 * @param {Case} each
 * @param {number} mostSamples
 * @param {number} mostSteps
 * @returns {Run}
 */
function carried(each, mostSamples, mostSteps) {
  const { kernels, system, drive, duration, tolerance } = each;
  const { layout } = kernels;
  const stretches = shake(kernels, drive.kind, drive.parameters);
  const instants = each.times ?? usualTimes(each, begin(kernels, recordOf(each, 0), stretches).driveRate,
    mostSamples);
  const kicks = each.noise ? drawKicks(each.noise, { duration, angles: system.angles,
    natural_frequency: system.naturalFrequency }) : { times: [], sizes: [] };
  const kick_sizes = kernels.take("f8", system.angles, kicks.times.length);
  kernels.numbers(kick_sizes).set(kicks.sizes);
  const given = { stretches, times: kernels.copy(instants), kick_times: kernels.copy(kicks.times),
    kick_sizes };
  const how = { balls: system.angles, duration, contact_limit: each.contactLimit,
    piece: each.clampStep ? "clamp" : "engine" };
  let step = 0;
  for (let halvings = 0; ; halvings += 1) {
    const { run: record, problem } = begin(kernels, recordOf(each, step), stretches);
    if (!["fine", "too many steps"].includes(problem)) throw new InputError(problem);
    step = kernels.get(record, "settings.step");
    if (duration / step > mostSteps)
      throw new InputError(`the run would take ${general(duration / step, 3)} steps of `
        + `${general(step, 3)} s, the limit is ${general(mostSteps, 1)}: shorten the duration, loosen the `
        + "tolerance or slow the motion");
    const result = integrate(kernels, { run: record, ...given }, how);
    const closes = kernels.get(record, "state.ledger_error") <= kernels.exports.allowed(record.at, tolerance);
    const repeats = !closes && !each.clampStep && result.status === "complete";
    const canRepeat = halvings < layout.most_halvings
      && kernels.get(record, "state.total_steps") <= layout.most_steps_to_repeat;
    if (!repeats || !canRepeat)
      return finished(each, instants, { run: record, ...given }, result, halvings, repeats);
    step *= 0.5;
    kernels.release(record);
  }
}

/**
 * Return the instants at which a run is sampled if nobody says: 100 in the shorter of the natural
 * and the driving period.
 * @param {Case} each
 * @param {number} driveRate [rad/s]
 * @param {number} most
 */
function usualTimes({ system, duration }, driveRate, most) {
  const fastest = Math.max(system.naturalFrequency, driveRate);
  const count = ((duration * fastest) / (2 * Math.PI)) * SAMPLES_PER_PERIOD;
  if (count > Math.min(MOST_DEFAULT_SAMPLES, most) && most === Infinity)
    throw new InputError(`${general(count, 3)} default samples exceed the limit of `
      + `${MOST_DEFAULT_SAMPLES}; ask for the instants you need with times`);
  return evenly(duration, Math.max(Math.min(Math.ceil(count) + 1, most), 2));
}

/**
 * @param {Case} each
 * @param {Float64Array} time
 * @param {import("../kernels/run.js").Prepared} prepared
 * @param {import("../kernels/run.js").Run} result
 * @param {number} halvings
 * @param {boolean} isLoose whether the ledger did not close
 * @returns {Run}
 */
function finished(each, time, prepared, result, halvings, isLoose) {
  const { kernels, system, duration } = each;
  const { layout } = kernels;
  const { run: record, stretches } = prepared;
  const count = system.angles;
  const balls = kernels.take("ball", count);
  for (const [i, ball] of system.balls.entries())
    for (const [name, value] of Object.entries(ball)) {
      kernels.numbers(kernels.field(balls, name, i))[0] = value;
    }
  const { pivot, out } = observe(kernels, prepared, result.samples, { balls, gravity: system.gravity,
    is_linear: system.linear, with_lab: each.frame === "both" });
  const rows = (/** @type {any} */ array, /** @type {number[]} */ numbers) => {
    const values = kernels.numbers(array);
    return numbers.map((row) => values.slice(row * time.length, (row + 1) * time.length));
  };
  const ofBalls = [...Array(count).keys()];
  /** @type {Record<string, Float64Array[]>} */
  const columns = {
    angle: rows(result.samples, ofBalls.map((i) => PER_BALL * i)),
    angular_velocity: rows(result.samples, ofBalls.map((i) => PER_BALL * i + 1)),
  };
  layout.pivot_rows.forEach((name, row) => { columns[name] = rows(pivot, [row]); });
  layout.ball_rows.forEach((name, row) => {
    const isLab = ["lab_energy", "rod_power"].includes(name);
    // The small-angle model has no such quantities.
    if ((isLab && each.frame !== "both") || (system.linear && (isLab || name === "tension"))) return;
    columns[name] = rows(out, ofBalls.map((i) => i * layout.ball_rows.length + row));
  });
  columns.total_energy = ofBalls.map((i) =>
    columns.kinetic_energy[i].map((value, k) => value + columns.potential_energy[i][k]));
  for (const name of LEDGER) {
    const [values] = rows(result.samples, [layout.sample_rows[name]]);
    if (name !== "noise_work" || values.some((/** @type {number} */ value) => Math.abs(value) > 0)) columns[name] = [values];
  }
  const { times: contactTimes, kinds, values } = result.contacts;
  const status = statusOf(each, result);
  if (status !== "complete" && !contactTimes.length && !columns.angle[0].some(Number.isFinite))
    throw new InputError(`the run ${status}; no sample and no contact is known`,
      { wayOut: "ask for earlier times" });
  const residual = kernels.get(record, "state.ledger_error");
  const known = result.status === "failed" ? NaN : 1;
  const [firsts, totals] = ["start", "time"].map((name) =>
    [...kernels.numbers(kernels.field(record, `state.compression_${name}`))].slice(0, count));
  const warnings = status === "complete" ? [] : [`the run ${status}; later samples are NaN`];
  if (isLoose) {
    const share = residual / kernels.get(record, "state.largest_energy");
    warnings.push(`the energy ledger closes to ${general(residual, 3)} J only, ${general(share, 2)} of the `
      + `largest energy: tolerance ${general(each.tolerance)} was not reached with step `
      + `${general(kernels.get(record, "settings.step"), 3)} s`);
  }
  return {
    time, columns, status, warnings, halvings, case: each, strobes: strobesOf(kernels, stretches, duration),
    contacts: { time: contactTimes, kind: Uint8Array.from(kinds),
      before: values.slice(0, count), after: values.slice(count === 1 ? 1 : 2, count === 1 ? 2 : 4) },
    energyResidual: residual, step: kernels.get(record, "settings.step"),
    grazes: kernels.get(record, "state.grazes"),
    compressionTime: firsts.map((value) => known * value),
    compressionFraction: totals.map((value) => (known * value) / result.reached),
  };
}

/**
 * Return how a run ended, as Python says it.
 * @param {Case} each
 * @param {import("../kernels/run.js").Run} result
 */
function statusOf(each, { status, reached }) {
  if (status === "complete") return status;
  const when = `${status} at t = ${general(reached, 9)} s`;
  return status === "failed" ? `${when}: the motion left the range of numbers`
    : `${when} by contact_limit = ${each.contactLimit}`;
}

/**
 * Return the instants up to `end` at which the drive's phase is a multiple of 2 pi [s]; none of a
 * drive without a phase, and of one that turns too often to be shown.
 * @param {Kernels} kernels
 * @param {import("../kernels/memory.js").Held} stretches
 * @param {number} end
 */
function strobesOf(kernels, stretches, end) {
  const turn = 2 * Math.PI;
  /** @type {number[]} */
  const instants = [];
  const get = (/** @type {string} */ name, /** @type {number} */ i) => kernels.get(stretches, name, i);
  for (let i = 0; i < stretches.shape[0]; i += 1) {
    const start = get("start", i);
    if (start > end || !PHASED.includes(get("form", i))) continue;
    const span = Math.min(i + 1 < stretches.shape[0] ? get("start", i + 1) : end, end) - start;
    const [phase, w, rate] = [get("phase", i), get("frequency", i), get("rate", i)];
    const reached = phase + span * (w + 0.5 * rate * span);
    if (!(Math.abs(reached - phase) < turn * MOST_STROBES)) return new Float64Array(0);
    if (!(w > 0 || rate > 0)) continue;
    const last = Math.floor(reached / turn + 1e-9);
    for (let n = Math.ceil(phase / turn - 1e-9); n <= last; n += 1) {
      const turned = turn * n - phase;
      // The root of w s + rate s^2/2 = turned, without loss of digits at small rates.
      instants.push(start + (2 * turned) / (w + Math.sqrt(Math.max(w * w + 2 * rate * turned, 0))));
    }
  }
  return Float64Array.from([...new Set(instants)].sort((a, b) => a - b));
}
