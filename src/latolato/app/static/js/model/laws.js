/** Systems, drives and contact laws from their parameters, checked as Python checks them. */

import { begin, shake } from "../kernels/begin.js";
import { foreign } from "./options.js";
import { brokenRule, checkedChoice, checkedNumber, noList, refusal } from "./rules.js";

/** @typedef {import("../kernels/memory.js").Kernels} Kernels */
/** @typedef {import("./registry.js").Registry} Registry */
/** @typedef {Record<string, any>} Values by the names of options */

/**
 * One ball of a system.
 * @typedef {{length: number, mass: number, damping: number, quadratic_damping: number,
 *   coulomb_damping: number, radius: number}} Ball
 *
 * A system: its balls whose angles are the state, the right one first, and where balls touch
 * [rad]: of one ball the angle, of two the separation.
 * @typedef {{kind: string, angles: number, contacts: boolean, linear: boolean, gravity: number,
 *   restitution: number, suspension: string, string_restitution: number, drag_frame: string,
 *   balls: Ball[], naturalFrequency: number, low: number, high: number}} System
 *
 * A drive: its parameters by the names that compiled code has.
 * @typedef {{kind: string, moves: boolean, parameters: Record<string, number | number[]>}} Drive
 */

const PARTS = ["length", "mass", "damping", "quadratic_damping", "coulomb_damping", "radius"];
const SIDES = ["right", "left"];
// Differences of decimal times are rounded by so much, relatively.
const ROUNDING = 1e-12;

/**
 * Return the law's numbers: what is given, and defaults; words and switches as they are.
 * @param {Registry} registry
 * @param {"system" | "drive"} part
 * @param {string} kind
 * @param {Values} input of this part only
 * @returns {Values}
 */
function numbersOf(registry, part, kind, input) {
  const law = registry[`${part}s`][kind];
  const own = law.options;
  for (const name of Object.keys(input))
    if (!own.includes(name)) throw foreign(registry, part, kind, name);
  /** @type {Values} */
  const values = {};
  for (const name of own) {
    const option = registry.options[name];
    const value = input[name] ?? option.default;
    if (value === null && !(name in input)) throw missing(registry, law.title, name);
    values[name] = value;
  }
  for (const name of own)
    if (registry.options[name].choices.length) checkedChoice(registry.options[name], name, values[name]);
  for (const name of own) {
    const option = registry.options[name];
    if (!option.unit || option.several) continue;
    values[name] = checkedNumber(option, name, values[name]);
  }
  return values;
}

/**
 * Return the error of a parameter that is not given.
 * @param {Registry} registry
 * @param {string} title of the law
 * @param {string} name
 */
function missing(registry, title, name) {
  const { path, unit } = registry.options[name];
  const law = { word: path.length === 1 ? title : "Ball" };
  return brokenRule("needed", { parameter: name }, { law, unit: unit ? ` [${unit}]` : "" });
}

/**
 * Return a system.
 * @param {Registry} registry
 * @param {Kernels} kernels of the module that has so many balls
 * @param {string} kind
 * @param {Values} input
 * @returns {System}
 */
export function systemOf(registry, kernels, kind, input) {
  const { angles, contacts } = registry.systems[kind];
  const values = numbersOf(registry, "system", kind, input);
  const prefixes = angles === 2 ? SIDES.map((side) => `${side}_`) : [""];
  const balls = prefixes.map((prefix) => /** @type {Ball} */ (Object.fromEntries(PARTS.map((part) =>
    [part, values[prefix + part] ?? 0]))));
  const { gravity, restitution = 1, suspension = "rod", string_restitution = 0, drag_frame = "pivot" } = values;
  const system = { kind, angles, contacts, linear: kind === "mathieu", gravity, restitution, suspension,
    string_restitution, drag_frame, balls, naturalFrequency: Math.sqrt(gravity / balls[0].length),
    low: -Infinity, high: Infinity };
  checkHanging(system);
  return contacts ? { ...system, ...wallsOf(kernels, system) } : system;
}

/**
 * Throw unless what balls hang on and the air around them go together with the rest.
 * @param {System} system
 */
export function checkHanging({ suspension, string_restitution: value, drag_frame: frame, balls }) {
  if (suspension === "rod" && value > 0)
    throw brokenRule("rigid_rod", { parameter: "string_restitution", value });
  if (frame === "lab" && balls.some((ball) => ball.quadratic_damping > 0))
    throw brokenRule("lab_drag", { parameter: "drag_frame", value: frame });
}

/**
 * Return the option for which a motion needs the modules of the plane, null if it does not.
 * @param {Registry} registry
 * @param {Record<string, any>} options
 */
export function planarOption({ drives }, { suspension, drag_frame: frame, drive = "fixed_pivot", ...options }) {
  if (suspension === "string") return "suspension";
  if (frame === "lab") return "drag_frame";
  const { across } = drives[drive];
  return across && options[across] ? across : null;
}

/**
 * Throw if a drive moves the pivot sideways and the system cannot follow it.
 * @param {Registry} registry
 * @param {System} system
 * @param {Drive} drive
 */
export function checkAcross(registry, { kind, linear, contacts, angles }, drive) {
  if (!planarOption(registry, { drive: drive.kind, ...drive.parameters })) return;
  const { title } = registry.systems[kind];
  const value = registry.drives[drive.kind].title;
  const parameter = "drive";
  if (contacts && angles === 1)
    throw brokenRule("mirrored_pivot", { parameter, value }, { law: { word: title } });
  if (linear) throw brokenRule("vertical_pivot", { parameter, value }, { law: { word: title } });
}

/**
 * Return the fields of a case that say what a system is.
 * @param {System} system
 * @returns {Record<string, number>}
 */
export function fieldsOf({ gravity, restitution, angles, linear, balls, ...hanging }) {
  const parts = balls.flatMap((ball, i) =>
    Object.entries(ball).map(([name, value]) => [`balls.${i}.${name}`, value]));
  return { gravity, restitution, angles, is_linear: Number(linear),
    is_string: Number(hanging.suspension === "string"), in_lab: Number(hanging.drag_frame === "lab"),
    string_restitution: hanging.string_restitution, ...Object.fromEntries(parts) };
}

/**
 * The contact angles of a system [rad].
 * @param {Kernels} kernels
 * @param {System} system
 */
function wallsOf(kernels, system) {
  const segments = shake(kernels, "fixed_pivot", {});
  const { run, problem } = begin(kernels, { ...fieldsOf(system), collides: 1, is_exact: 1, tolerance: 1 }, segments);
  const walls = { low: kernels.get(run, "settings.low"), high: kernels.get(run, "settings.high") };
  kernels.release(segments);
  if (problem) throw refusal(problem);
  return walls;
}

/**
 * Return a drive.
 * @param {Registry} registry
 * @param {string} kind
 * @param {Values} input
 * @returns {Drive}
 */
export function driveOf(registry, kind, input) {
  const values = numbersOf(registry, "drive", kind, input);
  const lists = Object.keys(values).filter((name) => registry.options[name].several);
  for (const name of lists) values[name] = checkedList(registry, name, values[name]);
  const { moves, amplitude_limit: limit } = registry.drives[kind];
  if (limit && !(values.drive_amplitude < values[limit[0]]))
    throw brokenRule("amplitude_limit", { parameter: "drive_amplitude", value: values.drive_amplitude },
      { name: limit[0], end: values[limit[0]], otherwise: { word: limit[1] } });
  if (lists.length) checkStages(values, lists);
  const parameters = Object.fromEntries(Object.entries(values).map(([name, value]) => {
    const { path, choices } = registry.options[name];
    return [path[0], choices.length ? choices.indexOf(value) : typeof value === "boolean" ? Number(value) : value];
  }));
  return { kind, moves, parameters };
}

/**
 * Return a list of numbers.
 * @param {Registry} registry
 * @param {string} name
 * @param {any} values
 */
export function checkedList(registry, name, values) {
  const option = registry.options[name];
  const parameter = name;
  if (!Array.isArray(values))
    throw noList(option.unit, { parameter, value: values });
  if (values.length < 1)
    throw brokenRule("list_length", { parameter }, { least: 1, values: { word: "value" }, count: 0 });
  return values.map((value, i) => checkedNumber(option, `${name}[${i}]`, value));
}

/**
 * Throw what is wrong with the stages of a drive.
 * @param {Values} values
 * @param {string[]} lists
 */
function checkStages(values, lists) {
  const parameter = "drive_times";
  const [times, ...others] = [values[parameter], ...lists.filter((name) => name !== parameter)];
  const lengths = [parameter, ...others].map((name) => values[name].length);
  if (new Set(lengths).size > 1) {
    const isPair = others.length === 1;
    const joined = (/** @type {any[]} */ each) => each.join(isPair ? " and " : ", ");
    throw brokenRule("one_length", { parameter },
      { names: joined(["{parameter}", ...others]), counts: joined(lengths) });
  }
  if (times[0] !== 0)
    throw brokenRule("first_stage", { parameter, value: times[0] });
  checkIncreasing(parameter, times);
  const gaps = times.slice(1).map((/** @type {number} */ time, /** @type {number} */ i) => time - times[i]);
  const shortest = Math.min(...gaps);
  if (gaps.length && values.ramp > shortest * (1 + ROUNDING))
    throw brokenRule("shortest_stage", { parameter: "ramp", value: values.ramp }, { shortest });
}

/**
 * Throw unless each value is larger than the one before.
 * @param {string} parameter
 * @param {ArrayLike<number>} values
 */
export function checkIncreasing(parameter, values) {
  for (let i = 1; i < values.length; i += 1) {
    if (values[i] > values[i - 1]) continue;
    throw brokenRule("increasing", { parameter }, { after: values[i], before: values[i - 1], place: i });
  }
}
