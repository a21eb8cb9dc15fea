/** Maps from parameters to observables, as `latolato.sweeps.chunk` and `.points`. */

import { ABSENT, problemAt, shakeAll } from "./begin.js";
import { moduleFor } from "./load.js";
import { drawKicks } from "./noise.js";
import { runPoints } from "./points.js";

/**
 * @typedef {import("./memory.js").HeldMemory} HeldMemory
 * @typedef {import("./memory.js").Kernels} Kernels
 *
 * One number for all points, or one for each.
 * @typedef {number | Float64Array} SweepColumn
 *
 * Points of a map. Nothing is checked against the ranges that parameters have.
 * @typedef {object} MapPoints
 * @property {number} count of points
 * @property {1 | 2} [angles] of the state, 1 if it is left out
 * @property {boolean} [in_plane] whether any point needs the engine for motions in the plane
 * @property {Record<string, SweepColumn>} parameters fields of the record `case` by their paths, such as
 *   `balls.0.mass`; others are zero, an offset and bounds of the drive not given. `is_linear`,
 *   `meets` (whether there are walls) and other whole numbers are the same for all points.
 * @property {{kind: string, parameters: Record<string, SweepColumn | number[]>}} drive
 * @property {{noise_strength: SweepColumn, noise_seed?: SweepColumn, noise_stream?: SweepColumn,
 *   noise_interval?: SweepColumn}} [noise] velocity kicks; without an interval 50 in a natural period
 * @property {"exact" | "clamp"} [contact] the law of contacts, exact if it is left out
 * @property {{name: string, parameters?: Record<string, number>}[]} observables only those that look
 *   at no drive periods take other parameters than the usual ones
 * @property {number} duration [s]
 * @property {SweepColumn} [transient] [s], 0 if it is left out
 * @property {SweepColumn} [period] of the drive [s], for observables that look at drive periods
 * @property {number} [contact_limit] contacts after which a point is given up
 * @property {Uint8Array} [impossible] 1 for points whose parameters contradict each other
 *
 * @typedef {{about: import("./memory.js").ObservableLayout, numbers: number[], first: number}} Observer
 */

const ROUGH = ["balls.0.quadratic_damping", "balls.0.coulomb_damping",
  "balls.1.quadratic_damping", "balls.1.coulomb_damping"];
// What is found out here, or is the same for all points.
const OWN = ["angles", "is_nonsmooth", "follows_tension", "mirrored"];
const FLAGS = ["is_linear", "collides", "is_string", "in_lab"];
// Both balls, and both as one body in sticking contact at the bottom and at the top.
const BODIES_OF_PAIR = 4;

/** @type {(column: SweepColumn, k: number) => number} */
const at = (column, k) => (typeof column === "number" ? column : column[k]);

/** @type {(column: SweepColumn, holds: (value: number) => boolean) => boolean} */
const some = (column, holds) => (typeof column === "number" ? holds(column) : column.some(holds));

/**
 * Return the name of the module that computes a map.
 * @param {Pick<MapPoints, "angles" | "in_plane">} question
 */
export function moduleOf({ angles = 1, in_plane: inPlane = false }) {
  return angles === 1 && !inPlane ? "lanes" : moduleFor(angles, inPlane);
}

/**
 * Return the values of all points by variable, point after point and of each point ball after ball,
 * NaN where a point has none, and the points' statuses and problems, numbers of those in the layout.
 * @param {Kernels} kernels of the module that `moduleOf` names
 * @param {MapPoints} question
 * @returns {{status: Uint8Array, problems: Uint8Array, values: Record<string, Float64Array>}}
 */
export function computeMap(kernels, question) {
  return cleared(kernels, () => computed(kernels, question));
}

/**
 * Return how many steps each point takes at least, NaN where its parameters make no sense, what is
 * wrong with the first, and whether points run in lanes; see `computeMap`.
 * @param {Kernels} kernels
 * @param {MapPoints} question
 * @returns {{steps: Float64Array, problem: import("./begin.js").Reported | null, in_lanes: boolean}}
 */
export function countSteps(kernels, question) {
  return cleared(kernels, () => {
    const { points, problems, held, in_lanes } = prepared(kernels, question);
    const { numbers, step } = kernels.column(points.settings, "step");
    const steps = Float64Array.from(problems, (problem, k) =>
      (problem ? NaN : question.duration / numbers[k * step]));
    return { steps, problem: problemAt(kernels, held, 0), in_lanes };
  });
}

/**
 * The result of a function, whose memory is released.
 * @template T
 * @param {Kernels} kernels
 * @param {() => T} compute
 */
function cleared(kernels, compute) {
  const first = kernels.take("f8", 0);
  try {
    return compute();
  } finally {
    kernels.release(first);
  }
}

/**
 * Return points at their beginning.
 * @param {Kernels} kernels
 * @param {MapPoints} question
 */
function prepared(kernels, question) {
  const { layout } = kernels;
  check(kernels, question);
  const { count, angles = 1, drive, duration, contact, contact_limit = layout.contact_limit } = question;
  const observers = observersOf(kernels, question.observables, angles);
  const marks = Math.max(0, ...observers.map(({ about }) => about.marks));
  const slots = observers.reduce((sum, { about }) => sum + about.slots, 0);
  const needs = new Set(observers.flatMap(({ about }) => about.needs));
  const isNonsmooth = ROUGH.some((name) => some(question.parameters[name] ?? 0, (value) => value > 0));
  const followsTension = needs.has("compression") && !question.parameters.is_linear;
  const { segments, firsts } = shakeAll(kernels, drive.kind, drive.parameters, count);
  const cases = kernels.take("case", count);
  const parameters = { ...ABSENT, ...question.parameters, duration, angles,
    is_nonsmooth: Number(isNonsmooth), follows_tension: Number(followsTension),
    mirrored: Number(observers.some(({ about }) => about.mirrored)) };
  for (const [path, column] of Object.entries(parameters)) fill(kernels, cases, path, column);
  const settings = kernels.take("settings", count);
  const bodies = kernels.take("body", count, angles === 1 ? 1 : BODIES_OF_PAIR);
  const stops = kernels.take("f8", count, 2 + marks);
  const states = kernels.take("state", count);
  const held = kernels.take("problem", count);
  const report = (/** @type {number} */ k, /** @type {string} */ name, /** @type {number[]} */ values = []) => {
    const number = layout.problems.findIndex((problem) => problem.name === name);
    kernels.numbers(kernels.field(held, "number", k))[0] = BigInt(number);
    kernels.numbers(kernels.field(held, "values", k)).set(values);
  };
  writeStops(kernels, question, marks, stops, (k, transient) => report(k, "transient", [transient, duration]));
  question.impossible?.forEach((flag, k) => { if (flag) report(k, "out of range"); });
  kernels.call("prepare", "cases", { cases, segments, firsts, settings, bodies, states,
    problems: held });
  const { numbers, step } = kernels.column(held, "number");
  const problems = Uint8Array.from({ length: count }, (_, k) => Number(numbers[k * step]));
  const in_lanes = angles === 1 && !question.in_plane && !question.noise && !isNonsmooth && contact !== "clamp"
    && layout.drives.some(({ name, rotates }) => name === drive.kind && rotates) && !needs.has("compression");
  const points = { settings, bodies, segments, firsts, stops, contact_limit };
  return { points, states, problems, held, observers, slots, needs, isNonsmooth, in_lanes };
}

/**
 * @param {Kernels} kernels
 * @param {MapPoints} question
 */
function computed(kernels, question) {
  const { layout } = kernels;
  const { count, angles = 1 } = question;
  const { is_linear = 0, collides = 0 } = question.parameters;
  const { points, states, problems, observers, slots, needs, isNonsmooth, in_lanes } =
    prepared(kernels, question);
  const columns = angles * count;
  const progress = { states, begun: kernels.take("state", count), status: kernels.take("i8", count),
    acc: kernels.take("f8", slots * columns) };
  for (const { numbers, first } of observers) {
    const acc = kernels.numbers(progress.acc);
    numbers.forEach((number, m) =>
      acc.fill(number, (first + m) * columns, (first + m + 1) * columns));
  }
  const order = longestFirst(kernels, points.settings, problems);
  if (order.shape[0]) {
    const { kicks, drifts, nodes } = layout.steppers[isNonsmooth ? "nonsmooth" : "smooth"];
    const stepper = { kicks: kernels.copy(kicks), drifts: kernels.copy(drifts),
      nodes: kernels.copy(nodes) };
    /** @type {import("./points.js").Points} */
    const all = { order, points: { ...points, ...kicksOf(kernels, question, problems) }, progress,
      stepper, slots, is_linear: Boolean(is_linear),
      engine: question.contact === "clamp" ? "clamp" : "engine" };
    runPoints(kernels, all, layout.occasions.map((name) => callbacksFor(observers, name)), in_lanes ? {
      walled: Boolean(collides), shown: [callbacksFor(observers, "step_report"), callbacksFor(observers, "jacobian_report")],
      needs: layout.shared_needs.filter((need) => needs.has(need)),
    } : null);
  }
  const invalid = layout.statuses.indexOf("invalid");
  const ended = kernels.numbers(progress.status);
  const status = problems.map((problem, k) => (problem ? invalid : Number(ended[k])));
  return { status, problems, values: valuesOf(kernels, observers, progress.acc, status, angles) };
}

/**
 * Throw what a question contradicts.
 * @param {Kernels} kernels
 * @param {MapPoints} question
 */
function check(kernels, question) {
  const { count, parameters, drive, noise, transient = 0, period = 0 } = question;
  if (kernels.name !== moduleOf(question)) throw new Error(`the module for this map is ${moduleOf(question)}`);
  for (const name of OWN) {
    if (name in parameters) throw new Error(`${name} is found out from the other parameters`);
  }
  for (const name of FLAGS) {
    const flag = parameters[name] ?? 0;
    if (flag !== 0 && flag !== 1) throw new Error(`${name} must be 0 or 1 for all points`);
  }
  if (parameters.is_linear && parameters.collides) {
    throw new Error("the linear restoring law knows no walls");
  }
  const columns = { ...parameters, ...drive.parameters, ...noise, transient, period };
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
 * @param {MapPoints["observables"]} names
 * @param {number} angles
 * @returns {Observer[]}
 */
function observersOf(kernels, names, angles) {
  const { observables } = kernels.layout;
  let first = 0;
  const observers = names.map(({ name, parameters = {} }) => {
    if (!Object.hasOwn(observables, name)) throw new Error(`no observable is called ${name}`);
    const about = observables[name];
    if (about.angles && about.angles !== angles) {
      throw new Error(`${name} belongs to systems of ${about.angles} angles`);
    }
    for (const key of Object.keys(parameters)) {
      if (!Object.hasOwn(about.parameters, key)) throw new Error(`${name} has no parameter ${key}`);
      if (about.marks) throw new Error(`${name} takes its usual parameters only`);
    }
    const numbers = Object.entries(about.parameters).map(([key, usual]) => parameters[key] ?? usual);
    const observable = { about, numbers, first };
    first += about.slots;
    return observable;
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
 * Return the kernels that are called on an occasion, each behind its first slot.
 * @param {Observer[]} observers
 * @param {string} occasion
 * @returns {[number, string][]}
 */
function callbacksFor(observers, occasion) {
  return observers.filter(({ about }) => occasion in about.callbacks)
    .map(({ about, first }) => [first, about.callbacks[occasion]]);
}

/**
 * Return the kicks of all points one after the other, and where those of each begin.
 * @param {Kernels} kernels
 * @param {MapPoints} question
 * @param {Uint8Array} problems
 */
function kicksOf(kernels, { count, angles = 1, parameters, noise, duration }, problems) {
  const kick_firsts = kernels.take("i8", count + 1);
  const firsts = [0];
  /** @type {{times: Float64Array, sizes: Float64Array}[]} */
  const drawn = [];
  for (let k = 0; k < count; k += 1) {
    if (noise && !problems[k]) {
      const own = Object.entries(noise).map(([name, column]) => [name, at(column, k)]);
      const [gravity, length] = ["gravity", "balls.0.length"].map((name) => at(parameters[name], k));
      drawn.push(drawKicks(/** @type {any} */ (Object.fromEntries(own)),
        { duration, natural_frequency: Math.sqrt(gravity / length), angles }));
    } else {
      drawn.push({ times: new Float64Array(0), sizes: new Float64Array(0) });
    }
    firsts.push(firsts[k] + drawn[k].times.length);
  }
  const kick_times = kernels.take("f8", firsts[count]);
  const kick_sizes = kernels.take("f8", angles, firsts[count]);
  kernels.numbers(kick_firsts).set(firsts.map(BigInt));
  const all = kernels.numbers(kick_times);
  const rows = kernels.numbers(kick_sizes);
  drawn.forEach(({ times, sizes }, k) => {
    all.set(times, firsts[k]);
    for (let i = 0; i < angles; i += 1) {
      const row = sizes.subarray(i * times.length, (i + 1) * times.length);
      rows.set(row, i * firsts[count] + firsts[k]);
    }
  });
  return { kick_times, kick_sizes, kick_firsts };
}

/**
 * Write a field of all records of an array.
 * @param {Kernels} kernels
 * @param {HeldMemory} records
 * @param {string} path
 * @param {SweepColumn} column
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
 * @param {MapPoints} question
 * @param {number} marks
 * @param {HeldMemory} stops
 * @param {(k: number, transient: number) => void} refuse called for points whose transient does not end
 *   before the run
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
    if (!(begin < duration)) refuse(k, begin);
  }
}

/**
 * Return the numbers of the points without a problem, those of most steps first: the last points
 * then are short ones.
 * @param {Kernels} kernels
 * @param {HeldMemory} settings
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
 * @param {HeldMemory} acc
 * @param {Uint8Array} status
 * @param {number} angles
 */
function valuesOf(kernels, observers, acc, status, angles) {
  const bad = kernels.layout.statuses.indexOf("event_limit");
  const slots = kernels.numbers(acc);
  const count = status.length;
  /** @type {Record<string, Float64Array>} */
  const values = {};
  for (const { about, first, numbers } of observers) {
    let slot = first + numbers.length;
    const balls = about.joint ? 1 : angles;
    for (const [name, width] of Object.entries(about.widths)) {
      const isExponent = about.dimension === "exponent" && !about.plain.includes(name);
      const kept = isExponent ? 2 * angles : width;
      const column = new Float64Array(count * balls * kept);
      for (let k = 0, i = 0; k < count; k += 1) {
        for (let ball = 0; ball < balls; ball += 1) {
          for (let m = 0; m < kept; m += 1, i += 1) {
            const place = ((slot + m) * count + k) * angles + ball;
            column[i] = status[k] >= bad ? NaN : slots[place];
          }
        }
      }
      values[name] = column;
      slot += width;
    }
  }
  return values;
}
