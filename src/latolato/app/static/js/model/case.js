/** What is to be run, from its parameters, checked as `latolato.simulate` checks it. */

import { begin, shake } from "../kernels/begin.js";
import { loadKernels, moduleFor } from "../kernels/load.js";
import { checkAcross, checkedList, checkIncreasing, driveOf, fieldsOf, planarOption, systemOf } from "./laws.js";
import { optionsOf, partsOf, withoutRatios } from "./options.js";
import { BeyondPageError, brokenRule, checkedChoice, checkedNumber, eitherOf, refusal, unknown } from "./rules.js";

/** @typedef {import("../kernels/memory.js").Kernels} Kernels */
/** @typedef {import("./registry.js").Registry} Registry */
/** @typedef {import("./options.js").OptionsRequest} OptionsRequest */
/** @typedef {import("./laws.js").System} System */
/** @typedef {import("./laws.js").Drive} Drive */

/**
 * What is to be run, checked: see `specify`.
 * @typedef {{registry: Registry, kernels: Kernels, options: Record<string, any>, system: System,
 *   drive: Drive, contact: string, clampStep: number, tolerance: number, restSpeed: number,
 *   contactLimit: number, frame: string, angles: number[], velocities: number[], distances: number[],
 *   offset: number | null, times: Float64Array | null, duration: number, noise: Noise | null}} Case
 * @typedef {{noise_strength: number, noise_seed?: number, noise_stream?: number,
 *   noise_interval?: number}} Noise
 */

/**
 * The case of a request, checked.
 * @param {Registry} registry
 * @param {OptionsRequest} request
 * @returns {Promise<Case>}
 */
export async function specify(registry, request) {
  const options = optionsOf(registry, request);
  const preset = registry.scenarios[request.scenario ?? ""];
  if (preset?.sweep)
    throw brokenRule("one_run", {}, { name: String(request.scenario), axes: Object.keys(preset.sweep.axes).join(", "),
      file: String(request.scenario) });
  const kind = String(options.system);
  if (!Object.hasOwn(registry.systems, kind))
    throw unknown("system", kind, Object.keys(registry.systems));
  const drive = options.drive ?? "fixed_pivot";
  if (!registry.systems[kind].compiled) throw new BeyondPageError("beyond_page", "system", kind);
  if (!registry.drives[drive]?.compiled) throw new BeyondPageError("beyond_page", "drive", drive);
  const planar = planarOption(registry, options);
  if (planar && registry.upright)
    throw brokenRule("beyond_notebook", { parameter: planar }, { name: String(options[planar]) });
  const kernels = await loadKernels(moduleFor(registry.systems[kind].angles, planar !== null));
  const parts = partsOf(registry, options);
  const system = systemOf(registry, kernels, kind, parts.system);
  withoutRatios(registry, drive, parts.drive, system.naturalFrequency);
  const moved = driveOf(registry, drive, parts.drive);
  checkAcross(registry, system, moved);
  const law = contactOf(registry, system, parts.run);
  const noise = noiseOf(registry, parts.noise);
  return { ...checkedRun(registry, kernels, options, system, moved, law, parts.run), noise };
}

/**
 * Return the random kicks of a run, null without any.
 * @param {Registry} registry
 * @param {Record<string, any>} noise
 */
export function noiseOf(registry, noise) {
  if (!Object.keys(noise).length) return null;
  const strength = registry.options.noise_strength;
  if (noise.noise_strength === undefined)
    throw brokenRule("needed", { parameter: "noise_strength" },
      { law: "VelocityKicks", unit: ` [${strength.unit}]` });
  return /** @type {Noise} */ (Object.fromEntries(Object.entries(noise).map(([name, value]) =>
    [name, checkedNumber(registry.options[name], name, value)])));
}

/**
 * Return the contact law of a run and the fixed step that it takes, 0 for none.
 * @param {Registry} registry
 * @param {System} system
 * @param {Record<string, any>} run
 */
export function contactOf(registry, system, run) {
  const laws = registry.contact_laws;
  const name = run.contact ?? registry.options.contact.default;
  if (typeof name !== "string")
    throw brokenRule("one_of", { parameter: "contact", value: name }, { names: Object.keys(laws).join(", ") });
  if (!Object.hasOwn(laws, name))
    throw unknown("contact law", name, Object.keys(laws));
  if (!laws[name].compiled) throw new BeyondPageError("law_beyond_page", "contact", name);
  const owners = (/** @type {string} */ option) =>
    Object.keys(laws).filter((law) => laws[law].options.includes(option));
  for (const option of Object.keys(run)) {
    if (!owners(option).length || owners(option).includes(name)) continue;
    throw brokenRule("foreign", { parameter: option },
      { part: { word: "contact" }, owners: eitherOf(owners(option)), kind: { word: name } });
  }
  const own = laws[name].options.map((option) => {
    const about = registry.options[option];
    return checkedNumber(about, option, run[option] ?? about.default);
  });
  if (!system.contacts && laws[name].options.length)
    throw brokenRule("meeting_balls", { parameter: "contact" },
      { name, law: { word: registry.systems[system.kind].title } });
  if (!system.contacts) return { contact: "none", clampStep: 0 };
  if (name === "clamp" && system.angles === 2)
    throw brokenRule("clamped_toy", { parameter: "contact" });
  const { suspension, drag_frame: frame } = system;
  if (name === "clamp" && (suspension !== "rod" || frame !== "pivot"))
    throw brokenRule("clamped_rods", { parameter: "contact" },
      { name, what: { word: suspension !== "rod" ? "strings" : "drag_frame 'lab'" } });
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
  const frame = checkedChoice(registry.options.frame, "frame", usual("frame"));
  const { times, duration } = instantsOf(registry, run);
  const each = { registry, kernels, options, system, drive, ...law, tolerance, restSpeed, contactLimit, frame,
    ...startOf(registry, system, run), times, duration };
  checkStart(each);
  if (law.clampStep > duration)
    throw brokenRule("clamp_step", { parameter: "clamp_step", value: law.clampStep }, { end: duration });
  return each;
}

/**
 * Return the fields of the kernel's record of a case.
 * @param {Omit<Case, "noise">} each
 * @param {number} step 0 for the one that the tolerance asks for
 */
export function recordOf(each, step) {
  const { system } = each;
  const pair = (/** @type {number[]} */ numbers) => [numbers[0], numbers[1] ?? 0];
  return {
    ...fieldsOf(system), initial_angle: pair(each.angles), initial_angular_velocity: pair(each.velocities),
    // The step is that of the whole drive, however long the run is.
    duration: Infinity, tolerance: each.tolerance, rest_speed: each.restSpeed, step: each.clampStep || step,
    collides: Number(system.contacts && each.contact !== "none"), follows_ledger: 1,
    follows_tension: Number(!system.linear),
    ...Object.fromEntries(each.distances.map((distance, i) => [`initial_distance.${i}`, distance])),
  };
}

/**
 * Throw unless a run can begin as it is to.
 * @param {Omit<Case, "noise">} each
 */
function checkStart(each) {
  const { kernels, drive, offset } = each;
  const segments = shake(kernels, drive.kind, drive.parameters);
  const { problem } = begin(kernels,
    { ...recordOf(each, 0), initial_offset: offset ?? NaN, duration: 0 }, segments);
  kernels.release(segments);
  if (problem) throw refusal(problem);
}

/**
 * Return the instants that are asked for, null for the usual ones, and the end of the run.
 * @param {Registry} registry
 * @param {Record<string, any>} run
 */
function instantsOf(registry, { times: given = null, samples = null, duration = null }) {
  const times = typeof given === "number" ? [given] : given;
  const endOf = (/** @type {any} */ value) => checkedNumber(registry.options.duration, "duration", value);
  if (samples !== null) {
    checkedNumber(registry.options.samples, "samples", samples);
    if (times !== null)
      throw brokenRule("either", { parameter: "samples" }, { name: "times" });
    if (duration === null) throw brokenRule("duration_of_samples", { parameter: "samples" });
    const end = endOf(duration);
    return { times: evenly(end, samples), duration: end };
  }
  if (times === null) {
    if (duration === null)
      throw brokenRule("duration_needed", { parameter: "duration" });
    return { times: null, duration: endOf(duration) };
  }
  const parameter = "times";
  checkedList(registry, parameter, times);
  checkIncreasing(parameter, times);
  const last = times[times.length - 1];
  if (duration === null && last <= 0)
    throw brokenRule("later_times", { parameter }, { last });
  const end = endOf(duration ?? last);
  if (times[0] < 0 || last > end)
    throw brokenRule("times_of_run", { parameter, value: times[0] < 0 ? times[0] : last }, { end });
  return { times: Float64Array.from(times), duration: end };
}

/**
 * Return evenly spaced instants from 0 to an end, the very ones of `numpy.linspace`.
 * @param {number} end
 * @param {number} count
 */
export function evenly(end, count) {
  const step = end / (count - 1);
  const times = new Float64Array(count);
  for (let i = 0; i < count; i += 1) times[i] = i * step;
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
export function numbersFor(registry, parameter, value, count) {
  const option = registry.options[parameter];
  const isList = Array.isArray(value);
  if (count === 1) {
    if (isList)
      throw brokenRule("one_number", { parameter, value }, { unit: option.unit });
    return [checkedNumber(option, parameter, value)];
  }
  const both = value === 0 ? [0, 0] : value;
  if (!Array.isArray(both) || both.length !== 2)
    throw brokenRule("two_numbers", { parameter, value });
  return both.map((each, i) => checkedNumber(option, `${parameter}[${i}]`, each));
}

/**
 * Return the offset that replaces an angle [rad], null for none.
 * @param {Registry} registry
 * @param {System} system
 * @param {Record<string, any>} run
 */
export function offsetOf(registry, system, { initial_angle: angle = null, initial_offset: offset = null }) {
  if (offset === null) return null;
  if (system.kind !== "latolato")
    throw brokenRule("offset_of_toy", { parameter: "initial_offset" });
  if (angle !== null)
    throw brokenRule("angle_or_offset", { parameter: "initial_angle" });
  return checkedNumber(registry.options.initial_offset, "initial_offset", offset);
}

/**
 * Return how a run begins; the kernel moves a start that is close to a wall onto it.
 * @param {Registry} registry
 * @param {System} system
 * @param {Record<string, any>} run
 */
function startOf(registry, system, run) {
  const { initial_angle: angle = null } = run;
  const parameter = "initial_angle";
  if (angle === null && (run.initial_offset ?? null) === null)
    throw brokenRule("angle_needed", { parameter });
  const offset = offsetOf(registry, system, run);
  const velocities = numbersFor(registry, "initial_angular_velocity",
    run.initial_angular_velocity ?? 0, system.angles);
  if (system.angles === 2 && !Array.isArray(angle))
    throw brokenRule("two_numbers", { parameter, value: angle });
  const angles = numbersFor(registry, parameter, offset === null ? angle : system.low + offset,
    system.angles);
  const distances = distancesOf(registry, system, run.initial_distance ?? null);
  return { angles, velocities, distances, offset };
}

/**
 * Throw for a parameter of strings unless balls hang on them.
 * @param {string} suspension
 * @param {string} parameter
 */
export function checkStrings(suspension, parameter) {
  if (suspension !== "string")
    throw brokenRule("of_strings", { parameter });
}

/**
 * Throw for a result on small perturbations where it is not known: on strings with dry friction.
 * @param {string} suspension
 * @param {number} friction  the largest coulomb_damping [N]
 * @param {string} what
 */
export function checkPerturbations(suspension, friction, what) {
  if (suspension === "string" && friction > 0)
    throw brokenRule("no_friction", { parameter: "coulomb_damping" }, { what });
}

/**
 * Return the distances from the pivot at which balls start [m], none for taut strings.
 * @param {Registry} registry
 * @param {System} system
 * @param {any} given
 */
function distancesOf(registry, { suspension, angles, balls }, given) {
  const parameter = "initial_distance";
  if (given === null) return [];
  checkStrings(suspension, parameter);
  const distances = numbersFor(registry, parameter, given, angles);
  return distances.every((distance, k) => distance === balls[k].length) ? [] : distances;
}
