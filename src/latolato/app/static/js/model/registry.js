/** What there is: laws, options, presets and quantities, as `latolato.app.forms` describes them. */

/**
 * An option. `low` and `high` are null where it has no end; `owner` and `path` say where a
 * scenario holds its value.
 * @typedef {{label: string, symbol: string, description: string, unit: string,
 *   units: {name: string, size: number}[], several: boolean, for_each_ball: boolean,
 *   choices: string[], switch: boolean, whole: boolean, default: any, usual: any,
 *   low: number | null, high: number | null,
 *   limits: {is_lower: boolean, end: number, is_open: boolean, rule: string, way_out: string}[],
 *   suggested: [number, number] | null, owner: "system" | "drive" | "run" | "noise",
 *   path: string[]}} Option
 *
 * A system, a drive or a contact law: its options in the order of its fields, and whether the
 * compiled modules have it.
 * @typedef {{title: string, description: string, options: string[], angles: number,
 *   contacts: boolean, compiled: boolean}} Law
 *
 * @typedef {{title: string, description: string, figure: string, given: Record<string, any>,
 *   options: Record<string, any>, sweep: any}} Preset
 *
 * @typedef {{version: string, systems: Record<string, Law>, drives: Record<string, Law>,
 *   contact_laws: Record<string, Law>, options: Record<string, Option>,
 *   quantities: Record<string, {unit: string, symbol: string, label: string}>,
 *   observables: Record<string, any>, scenarios: Record<string, Preset>,
 *   ratios: Record<string, string>, alternatives: string[][],
 *   trials: {columns: Record<string, string | null>, weak_angle: number, strong_angle: number},
 *   units: Record<string, [number, Record<string, number>]>, prefixes: Record<string, number>,
 *   server: boolean, docs?: boolean}} Registry
 */

import { loadJson } from "../kernels/load.js";

/**
 * Return the registry of this site; it is loaded once.
 * @returns {Promise<Registry>}
 */
export function loadRegistry() {
  return loadJson("registry.json");
}
