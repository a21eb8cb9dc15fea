/** Maps of one ball, from parameters to observables, as `latolato.sweeps.chunk` and `.points`. */

import { shake } from "./begin.js";
import { runPoints } from "./points.js";

/**
 * @typedef {import("./memory.js").Held} Held
 * @typedef {import("./memory.js").Kernels} Kernels
 *
 * One number for all points, or one for each.
 * @typedef {number | Float64Array} Column
 *
 * Points of a map: their number, fields of the record `case` by their paths (others are zero, an
 * offset and bounds of the drive not given), the drive, what is gathered (only observables that
 * look at no drive periods take other parameters than the usual ones), for how long in seconds, and
 * the drive's period [s] for those that do look.
 * @typedef {{count: number, parameters: Record<string, Column>,
 *   drive: {kind: string, parameters: Record<string, Column | number[]>},
 *   observables: {name: string, parameters?: Record<string, number>}[],
 *   duration: number, transient?: Column, period?: Column, contact_limit?: number}} Question
 */

const CONTACT_LIMIT = 1_000_000;
// Of one ball; two have four.
const EXPONENTS = 2;
const ABSENT = { initial_offset: NaN, pivot_bound: NaN, drive_rate: NaN };
// A drive period that ends this close behind the run's end, as a share, ends within it.
const LAST = 1e-14;

/** @type {(column: Column, k: number) => number} */
const at = (column, k) => (typeof column === "number" ? column : column[k]);

/**
 * Return the values of all points by variable, point after point, NaN where a point has none, and
 * the points' statuses and problems, numbers of those in the layout.
 * @param {Kernels} kernels of the module `lanes`
 * @param {Question} question
 * @returns {{status: Uint8Array, problems: Uint8Array, values: Record<string, Float64Array>}}
 */
export function computeMap(kernels, question) {
  const { layout } = kernels;
  const { count, parameters, drive, duration, contact_limit = CONTACT_LIMIT } = question;
  const first = kernels.take("f8", 0);
  const watched = question.observables.map((each) => watchedBy(kernels, each));
  const marks = Math.max(0, ...watched.map(({ about }) => about.marks));
  const slots = watched.reduce((sum, { about }) => sum + about.slots, 0);
  const { stretches, firsts } = shaken(kernels, count, drive);
  const cases = kernels.take("case", count);
  for (const [path, column] of Object.entries({ ...ABSENT, ...parameters, duration })) {
    fill(kernels, cases, path, column);
  }
  const points = {
    settings: kernels.take("settings", count), bodies: kernels.take("body", count, 1), stretches,
    firsts, kick_times: kernels.take("f8", 0), kick_sizes: kernels.take("f8", 1, 0),
    kick_firsts: kernels.take("i8", count + 1), stops: kernels.take("f8", count, 2 + marks),
    contact_limit,
  };
  const progress = {
    states: kernels.take("state", count), begun: kernels.take("state", count),
    status: kernels.take("i8", count), acc: kernels.take("f8", slots * count),
  };
  const problems = kernels.take("i8", count);
  const impossible = layout.problems.indexOf("out of range");
  writeStops(kernels, question, marks, points.stops, (k) => {
    kernels.numbers(problems)[k] = BigInt(impossible);
  });
  kernels.call("prepare", "cases", {
    cases, stretches, firsts, settings: points.settings, bodies: points.bodies,
    states: progress.states, problems,
  });
  const found = Uint8Array.from(kernels.numbers(problems), Number);
  let next = 0;
  for (const each of watched) {
    each.first = next;
    kernels.numbers(progress.acc).set(
      each.numbers.flatMap((number) => Array(count).fill(number)), next * count);
    next += each.about.slots;
  }
  const order = longestFirst(kernels, points.settings, found);
  if (order.shape[0]) {
    const { is_linear = 0, is_rough = 0, meets = 0 } = parameters;
    const rotates = layout.rotating_drives.includes(drive.kind);
    const inLanes = rotates && !is_rough && !watched.some(({ about }) => about.needs.includes("slack"));
    const weights = Object.entries(layout.steppers[is_rough ? "rough" : "smooth"])
      .filter(([, numbers]) => Array.isArray(numbers))
      .map(([name, numbers]) => [name, listed(kernels, numbers)]);
    runPoints(kernels, {
      order, points, progress, stepper: Object.fromEntries(weights), slots,
      is_linear: Boolean(is_linear),
    }, layout.occasions.map((name) => shown(watched, name)), inLanes ? {
      walled: Boolean(meets), shown: [shown(watched, "show"), shown(watched, "follow")],
      needs: layout.shared_needs.filter((need) => watched.some(({ about }) => about.needs.includes(need))),
    } : null);
  }
  const invalid = layout.statuses.indexOf("invalid");
  const status = Uint8Array.from(kernels.numbers(progress.status), (number, k) =>
    (found[k] ? invalid : Number(number)));
  const values = read(kernels, watched, progress.acc, status);
  kernels.release(first);
  return { status, problems: found, values };
}

/**
 * Return an observable with the numbers of its first slots.
 * @param {Kernels} kernels
 * @param {{name: string, parameters?: Record<string, number>}} asked
 */
function watchedBy(kernels, { name, parameters = {} }) {
  const about = kernels.layout.observables[name];
  if (!about) throw new Error(`no observable is called ${name}`);
  for (const key of Object.keys(parameters)) {
    if (!(key in about.parameters)) throw new Error(`${name} has no parameter ${key}`);
    if (about.marks) throw new Error(`${name} takes its usual parameters only`);
  }
  const numbers = Object.entries(about.parameters).map(([key, usual]) => parameters[key] ?? usual);
  return { about, numbers, first: 0 };
}

/**
 * Return what observables are shown on an occasion: pairs of first slot and piece.
 * @param {{about: import("./memory.js").Observable, first: number}[]} watched
 * @param {string} occasion
 * @returns {[number, string][]}
 */
function shown(watched, occasion) {
  return watched.filter(({ about }) => occasion in about.pieces)
    .map(({ about, first }) => [first, about.pieces[occasion]]);
}

/**
 * Return the stretches of all points' drives one after the other, and where those of each begin.
 * @param {Kernels} kernels
 * @param {number} count
 * @param {Question["drive"]} drive
 */
function shaken(kernels, count, { kind, parameters }) {
  const firsts = kernels.take("i8", count + 1);
  const parts = [];
  for (let k = 0, size = 0; k < count; k += 1) {
    const own = Object.entries(parameters).map(([name, value]) =>
      [name, value instanceof Float64Array ? value[k] : value]);
    const mark = kernels.take("f8", 0);
    const found = shake(kernels, kind, Object.fromEntries(own));
    parts.push(kernels.bytes(found).slice());
    kernels.release(mark);
    size += found.shape[0];
    kernels.numbers(firsts)[k + 1] = BigInt(size);
  }
  const stretches = kernels.take("stretch", Number(kernels.numbers(firsts)[count]));
  const bytes = kernels.bytes(stretches);
  parts.reduce((end, part) => (bytes.set(part, end), end + part.length), 0);
  return { stretches, firsts };
}

/**
 * Write a field of all records of an array.
 * @param {Kernels} kernels
 * @param {Held} records
 * @param {string} path
 * @param {Column} column
 */
function fill(kernels, records, path, column) {
  for (let k = 0; k < records.shape[0]; k += 1) {
    const field = kernels.field(records, path, k);
    kernels.numbers(field)[0] = field.type === "i8" ? BigInt(at(column, k)) : at(column, k);
  }
}

/**
 * Return numbers as an array in memory.
 * @param {Kernels} kernels
 * @param {number[]} numbers
 */
function listed(kernels, numbers) {
  const held = kernels.take("f8", numbers.length);
  kernels.numbers(held).set(numbers);
  return held;
}

/**
 * Write the instants at which steps must end: the transient's end, marks, the run's end.
 * @param {Kernels} kernels
 * @param {Question} question
 * @param {number} marks
 * @param {Held} stops
 * @param {(k: number) => void} refuse called for points whose transient has no end
 */
function writeStops(kernels, question, marks, stops, refuse) {
  const { count, duration, transient = 0, period = NaN } = question;
  const numbers = kernels.numbers(stops);
  for (let k = 0; k < count; k += 1) {
    const row = numbers.subarray(k * (2 + marks), (k + 1) * (2 + marks));
    const begin = at(transient, k);
    const each = at(period, k);
    const last = Math.floor((duration / each) * (1 + LAST));
    for (let mark = 0; mark < marks; mark += 1) {
      const number = last - (marks - 1 - mark);
      const instant = Math.min(number * each, duration);
      row[1 + mark] = number >= 0 && instant >= begin ? instant : NaN;
    }
    row[0] = begin;
    row[1 + marks] = duration;
    if (!(begin < duration)) refuse(k);
  }
}

/**
 * Return the numbers of the points without a problem, those of most steps first: the last points
 * then are short ones.
 * @param {Kernels} kernels
 * @param {Held} settings
 * @param {Uint8Array} problems
 */
function longestFirst(kernels, settings, problems) {
  const steps = Array.from(problems, (_, k) => kernels.get(settings, "step", k));
  const valid = [...steps.keys()].filter((k) => problems[k] === 0);
  valid.sort((one, other) => steps[one] - steps[other] || one - other);
  const order = kernels.take("i8", valid.length);
  kernels.numbers(order).set(valid.map(BigInt));
  return order;
}

/**
 * Return the variables of all points from their slots.
 * @param {Kernels} kernels
 * @param {{about: import("./memory.js").Observable, first: number, numbers: number[]}[]} watched
 * @param {Held} acc
 * @param {Uint8Array} status
 */
function read(kernels, watched, acc, status) {
  const bad = kernels.layout.statuses.indexOf("event_limit");
  const slots = kernels.numbers(acc);
  const count = status.length;
  /** @type {Record<string, Float64Array>} */
  const values = {};
  for (const { about, first, numbers } of watched) {
    let slot = first + numbers.length;
    for (const [name, width] of Object.entries(about.widths)) {
      const each = about.dimension === "exponent" ? EXPONENTS : width;
      const found = new Float64Array(count * each);
      for (let k = 0; k < count; k += 1) {
        for (let m = 0; m < each; m += 1) {
          found[k * each + m] = status[k] >= bad ? NaN : slots[(slot + m) * count + k];
        }
      }
      values[name] = found;
      slot += width;
    }
  }
  return values;
}
