/**
 * Recordings as files: JSON with the mark, the number of the format, the metadata and the arrays, each
 * with its shape and its values row by row. docs/how-to/app-live.md describes it.
 */

import { t } from "../strings.js";

/** @typedef {import("../shared/block.js").Block} Block */
/** @typedef {import("../shared/storage.js").Entry} Entry */

const MARK = "recording";
// The metadata of a recording, with the types that they must have.
const ABOUT = { options: "object", attributes: "object", balls: "object", contact_kinds: "object",
  ledger: "object", by_hand: "boolean", note: "string" };
const CONTACTS = ["contact_time", "contact_kind", "angular_velocity_before", "angular_velocity_after"];
const OF_STRINGS = ["radial_velocity_before", "radial_velocity_after", "contact_ball"];
const NEEDED = ["time", "angle", "angular_velocity", "pivot_height", ...CONTACTS];
const BALL = { name: "string", row: "number", sign: "number", length: "number", radius: "number",
  mass: "number" };

/**
 * Return a recording as the text of a file.
 * @param {{format: number}} registry
 * @param {Pick<Entry, "created" | "options">} entry
 * @param {Block} block
 */
export function fileText({ format }, { created, options }, { about, arrays, shapes }) {
  return JSON.stringify({
    latolato: MARK, format, created: new Date(created).toISOString(), options,
    about: Object.fromEntries(Object.keys(ABOUT).map((name) => [name, about[name]])),
    // JSON has no word for a number that is none; it is written as null.
    arrays: Object.fromEntries(Object.entries(arrays).map(([name, values]) =>
      [name, { shape: shapes[name], values: Array.from(values) }])),
  });
}

/**
 * The recording in a file.
 * @param {any} registry
 * @param {string} text
 * @returns {{about: Omit<Entry, "id" | "bytes">, block: Block}}
 * @throws {Error} that says what is wrong with it
 */
export function readFile(registry, text) {
  const isMarked = /^\s*\{\s*"latolato"\s*:\s*"recording"/.test(text);
  let data;
  try {
    data = JSON.parse(text);
  } catch {
    throw new Error(t(isMarked ? "recordingCut" : "recordingOther"));
  }
  if (data?.latolato !== MARK || !Number.isInteger(data.format)) throw new Error(t("recordingOther"));
  if (data.format > registry.format) throw new Error(t("recordingNewer"));
  const created = Date.parse(data.created);
  if (!isWhole(registry, data) || !Number.isFinite(created)) throw new Error(t("recordingCut"));
  const block = blockOf(data);
  const time = block.arrays.time;
  return { about: { created, duration: time[time.length - 1], options: data.options }, block };
}

/**
 * @param {any} data of a file that is whole
 * @returns {Block}
 */
function blockOf({ about, arrays }) {
  const each = (/** @type {(array: any, name: string) => any} */ make) => Object.fromEntries(
    Object.entries(arrays).map(([name, array]) => [name, make(array, name)]));
  return {
    about: { ...about, warnings: [], python: "", command: "" },
    arrays: each(({ values }, name) => (name === "contact_kind" ? Uint8Array.from(values)
      : Float64Array.from(values, (/** @type {number | null} */ value) => value ?? NaN))),
    shapes: each(({ shape }) => shape),
  };
}

/**
 * Return whether a value is a record with these names and types.
 * @param {any} value
 * @param {Record<string, string>} types
 */
function isRecord(value, types) {
  return typeof value === "object" && value !== null
    && Object.entries(types).every(([name, type]) => typeof value[name] === type && value[name] !== null);
}

/**
 * Return whether everything is there that views read.
 * @param {any} registry
 * @param {any} data
 */
function isWhole({ systems, drives, quantities }, { about, arrays, options }) {
  return isRecord({ about, arrays }, { about: "object", arrays: "object" })
    && typeof options === "object" && isRecord(about, ABOUT)
    && Object.hasOwn(systems, about.options.system) && Object.hasOwn(drives, about.options.drive)
    && Array.isArray(about.contact_kinds) && Array.isArray(about.balls) && about.balls.length > 0
    && about.balls.every((/** @type {any} */ ball) => isRecord(ball, BALL) && ball.length > 0)
    && NEEDED.every((name) => Object.hasOwn(arrays, name))
    && Object.keys(arrays).every((name) => name === "strobe" || name in quantities)
    && haveShapes(arrays, about) && isIncreasing(arrays.time.values);
}

/**
 * Return whether arrays have the numbers that their shapes say, and all rows of samples are as long as
 * the time, those of contacts as long as theirs.
 * @param {Record<string, any>} arrays
 * @param {any} about
 */
function haveShapes(arrays, { balls, contact_kinds: kinds }) {
  const rows = Math.max(...balls.map((/** @type {any} */ { row }) => row)) + 1;
  const isKind = (/** @type {any} */ value) => value in kinds;
  return Object.entries(arrays).every(([name, array]) => {
    const { shape, values } = array ?? {};
    if (!Array.isArray(shape) || !Array.isArray(values)) return false;
    const along = [...CONTACTS, ...OF_STRINGS].includes(name) ? "contact_time" : name === "strobe" ? "strobe" : "time";
    const length = arrays[along].values?.length;
    const isPlain = name === along || name === "contact_kind";
    const known = isPlain ? [[length]] : [[1, length], [rows, length]];
    return known.some((each) => String(each) === String(shape))
      && values.length === (isPlain ? length : shape[0] * length)
      && values.every(name === "contact_kind" ? isKind : isNumber);
  });
}

/** @param {any} value */
const isNumber = (value) => value === null || typeof value === "number";

/** @param {any[]} times */
const isIncreasing = (times) => times.length > 1
  && times.every((time, i) => time !== null && (i === 0 || time > times[i - 1]));
