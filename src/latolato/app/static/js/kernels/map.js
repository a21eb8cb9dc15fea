/** Maps of one ball, from parameters to observables, as `latolato.sweeps.chunk` and `.points`. */

import { ABSENT, shake } from "./begin.js";
import { runPoints } from "./points.js";

/**
 * @typedef {import("./memory.js").Held} Held
 * @typedef {import("./memory.js").Kernels} Kernels
 *
 * One number for all points, or one for each.
 * @typedef {number | Float64Array} Column
 *
 * Points of a map. Nothing is checked against the ranges that parameters have.
 * @typedef {object} Question
 * @property {number} count of points
 * @property {Record<string, Column>} parameters fields of the record `case` by their paths, such as
 *   `balls.0.mass`; others are zero, an offset and bounds of the drive not given. `is_linear`,
 *   `meets` (whether there are walls) and other whole numbers are the same for all points.
 * @property {{kind: string, parameters: Record<string, Column | number[]>}} drive
 * @property {{name: string, parameters?: Record<string, number>}[]} observables only those that look
 *   at no drive periods take other parameters than the usual ones
 * @property {number} duration [s]
 * @property {Column} [transient] [s], 0 if it is left out
 * @property {Column} [period] of the drive [s], for observables that look at drive periods
 * @property {number} [contact_limit] contacts after which a point is given up
 *
 * @typedef {{about: import("./memory.js").Observable, numbers: number[], first: number}} Observer
 */

// Lyapunov exponents of one ball; a pair has four.
const EXPONENTS = 2;
const ROUGH = ["balls.0.quadratic_damping", "balls.0.coulomb_damping"];
// What is found out here, or is the same for all points.
const OWN = ["angles", "is_rough", "follows_tension"];
const FLAGS = ["is_linear", "meets"];

/** @type {(column: Column, k: number) => number} */
const at = (column, k) => (typeof column === "number" ? column : column[k]);

/** @type {(column: Column, holds: (value: number) => boolean) => boolean} */
const some = (column, holds) => (typeof column === "number" ? holds(column) : column.some(holds));

/**
 * Return the values of all points by variable, point after point, NaN where a point has none, and
 * the points' statuses and problems, numbers of those in the layout.
 * @param {Kernels} kernels of the module `lanes`
 * @param {Question} question
 * @returns {{status: Uint8Array, problems: Uint8Array, values: Record<string, Float64Array>}}
 */
export function computeMap(kernels, question) {
  const first = kernels.take("f8", 0);
  try {
    return computed(kernels, question);
  } finally {
    kernels.release(first);
  }
}

/**
 * @param {Kernels} kernels
 * @param {Question} question
 */
function computed(kernels, question) {
  const { layout } = kernels;
  const { count, drive, duration, contact_limit = layout.contact_limit } = question;
  check(question);
  const observers = observersOf(kernels, question.observables);
  const marks = Math.max(0, ...observers.map(({ about }) => about.marks));
  const slots = observers.reduce((sum, { about }) => sum + about.slots, 0);
  const { is_linear = 0, meets = 0 } = question.parameters;
  const needs = new Set(observers.flatMap(({ about }) => about.needs));
  const isRough = ROUGH.some((name) => some(question.parameters[name] ?? 0, (value) => value > 0));
  const followsTension = needs.has("compression") && !is_linear;
  const { stretches, firsts } = stretchesOf(kernels, count, drive);
  const cases = kernels.take("case", count);
  const parameters = { ...ABSENT, ...question.parameters, duration, angles: 1,
    is_rough: Number(isRough), follows_tension: Number(followsTension) };
  for (const [path, column] of Object.entries(parameters)) fill(kernels, cases, path, column);
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
  const held = kernels.take("i8", count);
  const impossible = BigInt(layout.problems.indexOf("out of range"));
  writeStops(kernels, question, marks, points.stops, (k) => {
    kernels.numbers(held)[k] = impossible;
  });
  kernels.call("prepare", "cases", {
    cases, stretches, firsts, settings: points.settings, bodies: points.bodies,
    states: progress.states, problems: held,
  });
  const problems = Uint8Array.from(kernels.numbers(held), Number);
  for (const { numbers, first } of observers) {
    const acc = kernels.numbers(progress.acc);
    numbers.forEach((number, m) => acc.fill(number, (first + m) * count, (first + m + 1) * count));
  }
  const order = longestFirst(kernels, points.settings, problems);
  if (order.shape[0]) {
    const inLanes = layout.rotating_drives.includes(drive.kind) && !isRough && !needs.has("compression");
    const { kicks, drifts, nodes } = layout.steppers[isRough ? "rough" : "smooth"];
    const stepper = { kicks: kernels.copy(kicks), drifts: kernels.copy(drifts),
      nodes: kernels.copy(nodes) };
    const all = { order, points, progress, stepper, slots, is_linear: Boolean(is_linear) };
    runPoints(kernels, all, layout.occasions.map((name) => piecesFor(observers, name)), inLanes ? {
      walled: Boolean(meets), shown: [piecesFor(observers, "show"), piecesFor(observers, "follow")],
      needs: layout.shared_needs.filter((need) => needs.has(need)),
    } : null);
  }
  const invalid = layout.statuses.indexOf("invalid");
  const ended = kernels.numbers(progress.status);
  const status = problems.map((problem, k) => (problem ? invalid : Number(ended[k])));
  return { status, problems, values: valuesOf(kernels, observers, progress.acc, status) };
}

/**
 * Throw what a question contradicts.
 * @param {Question} question
 */
function check({ count, parameters, drive, transient = 0, period = 0 }) {
  for (const name of OWN) {
    if (name in parameters) throw new Error(`${name} is found out from the other parameters`);
  }
  for (const name of FLAGS) {
    const flag = parameters[name] ?? 0;
    if (flag !== 0 && flag !== 1) throw new Error(`${name} must be 0 or 1 for all points`);
  }
  if (parameters.is_linear && parameters.meets) {
    throw new Error("the linear restoring law knows no walls");
  }
  const columns = { ...parameters, ...drive.parameters, transient, period };
  for (const [name, column] of Object.entries(columns)) {
    if (column instanceof Float64Array && column.length !== count) {
      throw new Error(`${name} must have ${count} numbers, one for each point, got ${column.length}`);
    }
  }
  if (some(transient, (value) => !(value >= 0))) throw new Error("transient must be at least 0 s");
}

/**
 * Return observables with the numbers of their parameters and their first slots.
 * @param {Kernels} kernels
 * @param {Question["observables"]} asked
 * @returns {Observer[]}
 */
function observersOf(kernels, asked) {
  const { observables } = kernels.layout;
  let first = 0;
  const observers = asked.map(({ name, parameters = {} }) => {
    if (!Object.hasOwn(observables, name)) throw new Error(`no observable is called ${name}`);
    const about = observables[name];
    if (about.angles > 1) throw new Error(`${name} belongs to systems of ${about.angles} angles`);
    for (const key of Object.keys(parameters)) {
      if (!Object.hasOwn(about.parameters, key)) throw new Error(`${name} has no parameter ${key}`);
      if (about.marks) throw new Error(`${name} takes its usual parameters only`);
    }
    const numbers = Object.entries(about.parameters).map(([key, usual]) => parameters[key] ?? usual);
    const found = { about, numbers, first };
    first += about.slots;
    return found;
  });
  const variables = observers.flatMap(({ about }) => Object.keys(about.widths));
  const twice = variables.find((name, i) => variables.indexOf(name) !== i);
  if (twice) throw new Error(`two observables both give ${twice}: drop one`);
  const marks = new Set(observers.map(({ about }) => about.marks).filter(Boolean));
  if (marks.size > 1) {
    throw new Error("observables that look at drive periods must look at equally many: ask for one");
  }
  return observers;
}

/**
 * Return the pieces that are called on an occasion, each behind its first slot.
 * @param {Observer[]} observers
 * @param {string} occasion
 * @returns {[number, string][]}
 */
function piecesFor(observers, occasion) {
  return observers.filter(({ about }) => occasion in about.pieces)
    .map(({ about, first }) => [first, about.pieces[occasion]]);
}

/**
 * Return the stretches of all points' drives one after the other, and where those of each begin.
 * @param {Kernels} kernels
 * @param {number} count
 * @param {Question["drive"]} drive
 */
function stretchesOf(kernels, count, { kind, parameters }) {
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
  let end = 0;
  for (const part of parts) {
    bytes.set(part, end);
    end += part.length;
  }
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
  const { numbers, step, type } = kernels.column(records, path);
  for (let k = 0; k < records.shape[0]; k += 1) {
    numbers[k * step] = type === "i8" ? BigInt(at(column, k)) : at(column, k);
  }
}

/**
 * Write the instants at which steps must end: the transient's end, marks, the run's end.
 * @param {Kernels} kernels
 * @param {Question} question
 * @param {number} marks
 * @param {Held} stops
 * @param {(k: number) => void} refuse called for points whose transient does not end before the run
 */
function writeStops(kernels, question, marks, stops, refuse) {
  const { count, duration, transient = 0, period = NaN } = question;
  const numbers = kernels.numbers(stops);
  for (let k = 0; k < count; k += 1) {
    const row = numbers.subarray(k * (2 + marks), (k + 1) * (2 + marks));
    const begin = at(transient, k);
    const each = at(period, k);
    const last = Math.floor((duration / each) * (1 + kernels.layout.last_period));
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
  const { numbers, step } = kernels.column(settings, "step");
  const steps = Array.from(problems, (_, k) => numbers[k * step]);
  const valid = [...steps.keys()].filter((k) => problems[k] === 0);
  valid.sort((one, other) => steps[one] - steps[other] || one - other);
  const order = kernels.take("i8", valid.length);
  kernels.numbers(order).set(valid.map(BigInt));
  return order;
}

/**
 * Return the variables of all points from their slots.
 * @param {Kernels} kernels
 * @param {Observer[]} observers
 * @param {Held} acc
 * @param {Uint8Array} status
 */
function valuesOf(kernels, observers, acc, status) {
  const bad = kernels.layout.statuses.indexOf("event_limit");
  const slots = kernels.numbers(acc);
  const count = status.length;
  /** @type {Record<string, Float64Array>} */
  const values = {};
  for (const { about, first, numbers } of observers) {
    let slot = first + numbers.length;
    for (const [name, width] of Object.entries(about.widths)) {
      const kept = about.dimension === "exponent" ? EXPONENTS : width;
      const found = new Float64Array(count * kept);
      for (let k = 0; k < count; k += 1) {
        for (let m = 0; m < kept; m += 1) {
          found[k * kept + m] = status[k] >= bad ? NaN : slots[(slot + m) * count + k];
        }
      }
      values[name] = found;
      slot += width;
    }
  }
  return values;
}
