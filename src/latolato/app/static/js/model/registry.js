/** What there is: laws, options, presets and quantities, as `latolato.app.forms` describes them. */

/**
 * An option. `low` and `high` are null where it has no end; `owner` and `path` say where a
 * scenario holds its value. Descriptions leave out the default of one that `is_later`.
 * @typedef {{label: string, symbol: string, description: string, unit: string,
 *   units: {name: string, size: number}[], several: boolean, for_each_ball: boolean,
 *   choices: string[], switch: boolean, whole: boolean, default: any, usual: any,
 *   low: number | null, high: number | null,
 *   limits: {is_lower: boolean, end: number, is_open: boolean, rule: string, values: Record<string, string>}[],
 *   suggested: [number, number] | null, owner: "system" | "drive" | "run" | "noise",
 *   path: string[], is_later: boolean}} Option
 *
 * A system, a drive or a contact law: its options in the order of its fields, whether the compiled
 * modules have it, and what maps can vary of it.
 * @typedef {{title: string, description: string, options: string[], angles: number,
 *   contacts: boolean, compiled: boolean, axes?: string[]}} Law
 *
 * A drive, as `latolato.physics.drives.base` describes it: whether it moves the pivot, as a sinusoid, and
 * repeats itself; the option that moves the pivot sideways unless it is zero; and the option that
 * `drive_amplitude` must stay below, with what happens otherwise.
 * @typedef {Law & {moves: boolean, sinusoidal: boolean, periodic: boolean, across: string | null,
 *   amplitude_limit: [string, string] | null}} DriveLaw
 *
 * What maps can vary: `sets` is the parameter that it stands for.
 * @typedef {{label: string, symbol: string, unit: string, units: {name: string, size: number}[],
 *   owner: "system" | "drive" | "run" | "noise", sets: string, limits: Option["limits"],
 *   suggested: [number, number] | null}} Varied
 *
 * An observable. A variable whose values are classes names them, each with its colour; others have
 * the colours of the reproduction report, logarithmic or not. Contact words have `words`.
 * @typedef {{title: string, description: string, variables: Record<string, {unit: string, symbol: string,
 *   label: string, units: {name: string, size: number}[], classes: [string, string][], log: boolean,
 *   scale: string, words: import("../map/class_words.js").Words}>}} Observable
 *
 * @typedef {{title: string, question: string, description: string, figure: string, given: Record<string, any>,
 *   options: Record<string, any>, sweep: any, curves?: string | null}} Preset `curves` is the path of the
 *   bifurcation curves over its map
 *
 * @typedef {{version: string, format: number, systems: Record<string, Law>, drives: Record<string, DriveLaw>,
 *   contact_laws: Record<string, Law>, options: Record<string, Option>,
 *   quantities: Record<string, {unit: string, symbol: string, label: string, shown_unit: string}>,
 *   axes: Record<string, Varied>, noise_axes: string[], observables: Record<string, Observable>,
 *   default_observables: string[], sweep_tolerance: number, scenarios: Record<string, Preset>,
 *   ratios: Record<string, string>, alternatives: string[][], rules: Record<string, import("./rules.js").Rule>,
 *   trials: {columns: Record<string, string | null>, weak_angle: number, strong_angle: number},
 *   units: Record<string, [number, Record<string, number>]>, prefixes: Record<string, number>,
 *   curves: {kinds: Record<string, {label: string, colour: string}>, marks: Record<string, {label: string, mark: string}>},
 *   languages: Record<string, {name: string, beta: boolean}>, server: boolean, docs?: boolean, report?: boolean, upright?: boolean}} Registry
 *
 * Cells of notebooks have a registry that is `upright`: they lack the modules of the plane.
 */

import { loadJson } from "../kernels/files.js";
import { learnRules } from "./rules.js";

/**
 * Put the texts of a registry, which are English, in another language. What Python calls a law
 * (`title`) and what files are written with (`quantities`) stay.
 * @param {Registry} registry
 * @param {(text: string) => string} translated
 */
export function translateRegistry({ systems, drives, contact_laws: laws, options, axes, observables,
  scenarios }, translated) {
  const put = (/** @type {any} */ entry, /** @type {string[]} */ ...keys) => {
    for (const key of keys) if (entry[key]) entry[key] = translated(entry[key]);
  };
  for (const part of [systems, drives, laws])
    for (const law of Object.values(part)) put(law, "description");
  for (const option of Object.values(options)) put(option, "label", "description");
  for (const axis of Object.values(axes)) put(axis, "label");
  for (const observable of Object.values(observables)) {
    put(observable, "description");
    for (const variable of Object.values(observable.variables)) {
      put(variable, "label");
      for (const named of variable.classes) named[0] = translated(named[0]);
    }
  }
  for (const scenario of Object.values(scenarios)) put(scenario, "title", "question", "description");
}

/**
 * Return the registry of this site; it is loaded once, and brings the sentences of rules.
 * @returns {Promise<Registry>}
 */
export async function loadRegistry() {
  const registry = await loadJson("registry.json");
  learnRules(registry.rules);
  return registry;
}
