/** Trials of an experiment from the text of a trial table: `latolato.experiment.trial_table`. */

import { brokenRule, InputError } from "../model/rules.js";
import { toSi } from "../model/units.js";
import { inLanguage } from "../page/refusals.js";
import { t } from "../strings.js";
import { CLASSES } from "./marks.js";

/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("./theory.js").Placing} Placing */
/** @typedef {{amplitude: number[], frequency: number[], ratio: number[], kinds: number[]}} TrialTable */
/** @typedef {Map<string, any[]>} Columns */

// Ends of lines as Python knows them.
export const LINE_END = /\r\n|[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]/;

/**
 * Return the trials of a table in the coordinates of a map, and how many lie outside of it.
 * @param {TrialTable} table
 * @param {Placing} placing
 * @returns {{trials: import("./chart.js").Trials, outside: number}}
 */
export function placedTrials({ amplitude, frequency, ratio, kinds }, placing) {
  const isPlain = "drive_frequency" in placing.spans;
  const places = amplitude.map((each, i) => {
    // In natural frequencies of the toy that was measured, where these are known.
    const byRatio = ratio[i] * placing.naturalFrequency;
    const [first, second] = isPlain ? [frequency[i], byRatio] : [byRatio, frequency[i]];
    return placing.place({ amplitude: each, frequency: Number.isFinite(first) ? first : second });
  });
  const spans = [placing.spans[placing.x], placing.spans[placing.y]];
  const isOutside = (/** @type {number[]} */ place) =>
    place.some((value, k) => value < spans[k][0] || value > spans[k][1]);
  return { outside: places.filter(isOutside).length,
    trials: { xs: places.map(([x]) => x), ys: places.map(([, y]) => y), kinds } };
}

/**
 * Return the trials that the text of a CSV holds.
 * @param {Registry} registry
 * @param {string} text
 * @returns {TrialTable}
 * @throws {InputError} for what is no trial table
 */
export function parseTrials(registry, text) {
  const { columns: units, weak_angle: weak, strong_angle: strong } = registry.trials;
  const lines = text.replace(/^\ufeff/, "").split(LINE_END);
  const columns = columnsOf(lines.filter((line) => !line.startsWith("#")));
  if (columns.has("stabilised_angle"))
    throw brokenRule("renamed_column", {},
      { former: "stabilised_angle", name: "largest_angle_after_transient" });
  /** @type {Columns} */
  const read = new Map();
  for (const [heading, values] of columns) {
    // A name may carry the unit of its cells: "drive_amplitude [mm]".
    const [name, written = ""] = heading.replace(/(?: \[1)?\]$/, "").split(" [");
    const cells = values.map((value) => (value && `${value} ${written}`.trim()));
    if (!Object.hasOwn(units, name) || !cells.some(Boolean)) continue;
    read.set(name, cells.map((cell, i) => inTrial(i + 1, () => readCell(registry, name, cell, units[name]))));
  }
  const gravity = gravityOf(registry, lines);
  const kinds = read.get("class");
  const amplitude = read.get("drive_amplitude");
  if (!amplitude || !(read.has("drive_frequency") || read.has("frequency_ratio")))
    throw brokenRule("trial_columns", read.size ? { value: [...read.keys()].join(", ") } : {});
  for (const name of ["drive_amplitude", "drive_frequency", "frequency_ratio", "length"]) {
    const isUnknown = (/** @type {number} */ value) => name === "length" && Number.isNaN(value);
    const at = read.get(name)?.findIndex((value) =>
      !((value > 0 && Number.isFinite(value)) || isUnknown(value))) ?? -1;
    if (at >= 0)
      throw brokenRule("positive_in_row", { parameter: name, value: read.get(name)?.[at] }, { row: at + 1 });
  }
  const unknown = amplitude.map(() => NaN);
  const natural = (read.get("length") ?? unknown).map((length) => Math.sqrt(gravity / length));
  const frequency = read.get("drive_frequency");
  const ratio = read.get("frequency_ratio")
    ?? /** @type {number[]} */ (frequency).map((each, i) => each / natural[i]);
  const [largest, settled] = ["largest_angle", "largest_angle_after_transient"].map((name) =>
    read.get(name) ?? unknown);
  if (!kinds && ![...largest, ...settled].every(Number.isFinite))
    throw brokenRule("trial_extremes");
  return { amplitude, ratio, frequency: frequency ?? ratio.map((each, i) => each * natural[i]),
    kinds: kinds ?? largest.map((each, i) => (each >= strong ? 2 : settled[i] >= weak ? 1 : 0)) };
}

/** @param {string} text */
function numberOfClass(text) {
  const name = text.toLowerCase();
  if (!CLASSES.includes(name))
    throw brokenRule("choice", { parameter: "class", value: name }, { words: "'none', 'weak'", last: "'strong'" });
  return CLASSES.indexOf(name);
}

/**
 * Return the gravity that a comment of the table names, else the usual one [m/s^2].
 * @param {Registry} registry
 * @param {string[]} lines
 */
function gravityOf(registry, lines) {
  const given = lines.map((line) => /^#\s*gravity\s*:(.*)$/.exec(line)?.[1].trim())
    .findLast((text) => text !== undefined);
  if (given === undefined) return registry.options.gravity.default;
  const gravity = toSi(registry, "gravity", given, "m/s^2");
  if (gravity > 0 && Number.isFinite(gravity)) return gravity;
  throw brokenRule("positive", { parameter: "gravity", value: gravity });
}

/**
 * Return what a cell holds: a text, the number of a class, or a number, which may have a unit; NaN for an empty one.
 * @param {Registry} registry
 * @param {string} name
 * @param {string} cell
 * @param {string | null} unit
 */
function readCell(registry, name, cell, unit) {
  if (name === "class") return numberOfClass(cell);
  if (unit === null) return cell;
  return cell ? toSi(registry, name, cell, unit) : NaN;
}

/**
 * Return what a function returns; what it refuses names the trial.
 * @template T
 * @param {number} number
 * @param {() => T} read
 */
function inTrial(number, read) {
  try {
    return read();
  } catch (error) {
    if (!(error instanceof InputError)) throw error;
    throw new InputError(t("refuseTrial", { number, text: inLanguage(error) }));
  }
}

/**
 * Return the cells of each column of a CSV below its name, without space around them.
 * @param {string[]} lines
 * @returns {Map<string, string[]>}
 */
export function columnsOf(lines) {
  const [names, ...rows] = rowsOf(lines);
  if (!names) throw brokenRule("columns");
  rows.forEach((row, i) => {
    if (row.length !== names.length)
      throw brokenRule("cells_of_row", {}, { row: i + 1, cells: row.length, names: names.length });
  });
  return new Map(names.map((name, k) => [name.trim(), rows.map((row) => row[k].trim())]));
}

/**
 * Return the cells of the rows of a CSV, as Python's `csv` reads it; empty lines are left out.
 * @param {string[]} lines
 * @returns {string[][]}
 */
function rowsOf(lines) {
  /** @type {string[][]} */
  const rows = [];
  // Cells in quotes may hold commas, line ends and quotes, which are doubled there.
  const cell = /(?:"((?:[^"]|"")*)(?:"|$))?([^,\n]*)(,|\n|$)/gy;
  const text = lines.join("\n");
  let row = [];
  for (cell.lastIndex = 0; cell.lastIndex < text.length;) {
    const [, quoted, plain, end] = /** @type {RegExpExecArray} */ (cell.exec(text));
    row.push((quoted?.replaceAll('""', '"') ?? "") + plain);
    if (end === "," && cell.lastIndex < text.length) continue;
    if (end === ",") row.push("");
    if (row.length > 1 || quoted !== undefined || plain) rows.push(row);
    row = [];
  }
  return rows;
}
