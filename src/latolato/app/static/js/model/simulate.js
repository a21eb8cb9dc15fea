/** One run from its parameters to its columns, as `latolato.simulate`. */

import { begin, problemOf, shake } from "../kernels/begin.js";
import { drawKicks } from "../kernels/noise.js";
import { integrate, observe } from "../kernels/run.js";
import { evenly, recordOf } from "./case.js";
import { brokenRule, refusal, sentenceOf } from "./rules.js";

/** @typedef {import("../kernels/memory.js").Kernels} Kernels */
/** @typedef {import("./case.js").Case} Case */
/** @typedef {import("./rules.js").Sentence} Sentence */

/**
 * A run: columns over the instants, one for each ball of those quantities that balls have.
 * @typedef {{time: Float64Array, columns: Record<string, Float64Array[]>, strobes: Float64Array,
 *   contacts: {time: Float64Array, kind: Uint8Array, before: Float64Array[], after: Float64Array[],
 *     others: Record<string, Float64Array[]>},
 *   status: string | Sentence, energyResidual: number, step: number, halvings: number, grazes: number,
 *   pulls: Record<string, number[]>, warnings: Sentence[], case: Case}} Run
 */

const SAMPLES_PER_PERIOD = 100;
// A run that is seen for a moment has so many samples in the stretch on show, and as many in all of it: a
// sample takes longer than the step in which it lies.
const MOST_THINNED = 3000;
const MOST_DEFAULT_SAMPLES = 20_000_000;
const MOST_STEPS = 1e9;
export const LEDGER = ["drive_work", "damping_loss", "impact_loss", "capture_loss", "noise_work",
  "retension_loss"];
// Of the samples: an angle and its velocity for each ball.
const PER_BALL = 2;
// Of strings: distance, its rate and whether it is slack.
export const PER_STRING = 3;
const MOST_STROBES = 20_000;
// Forms of segments that have a phase: cosine, swept cosine, crank; see `physics.drives.segment`.
const PHASED = [1, 2, 3];

/**
 * The run of a case.
 * @param {Case} each
 * @param {number} [mostSamples] of a run whose instants were not asked for
 * @param {[number, number] | null} [stretch] on show, of a run that is seen for a moment [s]
 * @returns {Run}
 */
export function run(each, mostSamples = Infinity, stretch = null) {
  const { kernels } = each;
  const first = kernels.take("f8", 0);
  try {
    return carried(each, mostSamples, stretch);
  } finally {
    kernels.release(first);
  }
}

/**
 * @param {Case} each
 * @param {number} mostSamples
 * @param {[number, number] | null} stretch
 * @returns {Run}
 */
function carried(each, mostSamples, stretch) {
  const { kernels, system, drive, duration, tolerance } = each;
  const { layout } = kernels;
  const segments = shake(kernels, drive.kind, drive.parameters);
  const times = each.times ?? usualTimes(each, begin(kernels, recordOf(each, 0), segments).driveRate,
    mostSamples);
  const instants = stretch ? thinned(times, stretch) : times;
  const kicks = each.noise ? drawKicks(each.noise, { duration, angles: system.angles,
    natural_frequency: system.naturalFrequency }) : { times: [], sizes: [] };
  const kick_sizes = kernels.take("f8", system.angles, kicks.times.length);
  kernels.numbers(kick_sizes).set(kicks.sizes);
  const inputs = { segments, times: kernels.copy(instants), kick_times: kernels.copy(kicks.times),
    kick_sizes };
  const how = { balls: system.angles, duration, contact_limit: each.contactLimit,
    engine: each.clampStep ? "clamp" : "engine" };
  let step = 0;
  for (let halvings = 0; ; halvings += 1) {
    const { run: record } = begin(kernels, recordOf(each, step), segments);
    step = kernels.get(record, "settings.step");
    if (duration / step > MOST_STEPS)
      throw refusal(problemOf(layout, "too many steps", [duration / step, step, MOST_STEPS]));
    const result = integrate(kernels, { run: record, ...inputs }, how);
    const closes = kernels.get(record, "state.ledger_error") <= kernels.exports.allowed(record.at, tolerance);
    const repeats = !closes && !each.clampStep && result.status === "complete";
    const canRepeat = halvings < layout.most_halvings
      && kernels.get(record, "state.total_steps") <= layout.most_steps_to_repeat;
    if (!repeats || !canRepeat)
      return finished(each, instants, { run: record, ...inputs }, result, halvings, repeats);
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
    throw brokenRule("default_samples", {}, { count, limit: MOST_DEFAULT_SAMPLES });
  return evenly(duration, Math.max(Math.min(Math.ceil(count) + 1, most), 2));
}

/**
 * Return some of the instants of a run, most of them in a stretch of it.
 * @param {Float64Array} times
 * @param {[number, number]} stretch
 */
function thinned(times, [from, to]) {
  const isInside = (/** @type {number} */ time) => time >= from && time <= to;
  const [inside, outside] = [times.filter(isInside), times].map(({ length }) => Math.ceil(length / MOST_THINNED));
  return times.filter((time, i) => i % (isInside(time) ? inside : outside) === 0 || i === times.length - 1);
}

/**
 * @param {Case} each
 * @param {Float64Array} time
 * @param {import("../kernels/run.js").Prepared} prepared
 * @param {import("../kernels/run.js").KernelRun} result
 * @param {number} halvings
 * @param {boolean} isLoose whether the ledger did not close
 * @returns {Run}
 */
function finished(each, time, prepared, result, halvings, isLoose) {
  const { kernels, system, duration } = each;
  const { layout } = kernels;
  const { run: record, segments } = prepared;
  const count = system.angles;
  const balls = kernels.take("ball", count);
  for (const [i, ball] of system.balls.entries())
    for (const [name, value] of Object.entries(ball)) {
      kernels.numbers(kernels.field(balls, name, i))[0] = value;
    }
  const { pivot, out } = observe(kernels, prepared, result.samples, { balls, gravity: system.gravity,
    is_linear: system.linear, in_lab: system.drag_frame === "lab", with_lab: each.frame === "both" });
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
  const isString = system.suspension === "string";
  if (isString)
    for (const [name, row] of Object.entries(layout.string_rows))
      columns[name] = rows(result.samples, ofBalls.map((i) => row + PER_STRING * i));
  // A run that failed knows nothing more.
  columns.slack?.forEach((row) => row.forEach((value, i) => { row[i] = value || 0; }));
  kernels.rows.pivot.forEach((name, row) => { columns[name] = rows(pivot, [row]); });
  layout.ball_rows.forEach((name, row) => {
    const isLab = ["lab_energy", "rod_power"].includes(name);
    // The small-angle model has no such quantities.
    if ((isLab && each.frame !== "both") || (system.linear && (isLab || name === "tension"))) return;
    columns[name] = rows(out, ofBalls.map((i) => i * layout.ball_rows.length + row));
  });
  columns.total_energy = ofBalls.map((i) => sum(columns.kinetic_energy[i], columns.potential_energy[i]));
  for (const name of LEDGER) {
    if ((name === "noise_work" && !each.noise) || (name === "retension_loss" && !isString)) continue;
    const [values] = rows(result.samples, [layout.sample_rows[name]]);
    if (name !== "noise_work" || values.some((/** @type {number} */ value) => Math.abs(value) > 0)) columns[name] = [values];
  }
  const { times: contactTimes, kinds, values } = result.contacts;
  const status = statusOf(each, result);
  if (status !== "complete" && !contactTimes.length && !columns.angle[0].some(Number.isFinite))
    throw brokenRule("no_sample", {}, { status });
  const residual = kernels.get(record, "state.ledger_error");
  const known = result.status === "failed" ? NaN : 1;
  const ofState = (/** @type {string} */ name) =>
    [...kernels.numbers(kernels.field(record, `state.${name}`))].slice(0, count).map((value) => known * value);
  const [first, share] = isString ? ["first_slack", "slack_fraction"] : ["compression_time", "compression_fraction"];
  const what = isString ? "slack" : "compression";
  const pulls = system.linear ? {} : { [first]: ofState(`${what}_start`),
    [share]: ofState(`${what}_time`).map((value) => value / result.reached),
    ...(isString ? { largest_string_impulse: [known * kernels.get(record, "state.string_impulse")] } : {}) };
  const warnings = status === "complete" ? [] : [sentenceOf("ended_early", { status })];
  if (isLoose) {
    const share = residual / kernels.get(record, "state.largest_energy");
    warnings.push(sentenceOf("open_ledger",
      { residual, share, tolerance: each.tolerance, step: kernels.get(record, "settings.step") }));
  }
  return {
    time, columns, status, warnings, halvings, case: each, strobes: strobesOf(kernels, segments, duration),
    contacts: { time: contactTimes, kind: Uint8Array.from(kinds),
      before: values.slice(0, count), after: values.slice(count, 2 * count),
      others: isString ? onStrings(layout, values, count) : {} },
    energyResidual: residual, step: kernels.get(record, "settings.step"),
    grazes: kernels.get(record, "state.grazes"), pulls,
  };
}

/**
 * Further columns for contacts of balls on strings: radial velocities [m/s], and
 * the ball where there are two.
 * @param {import("../kernels/memory.js").Layout} layout
 * @param {Float64Array[]} values
 * @param {number} count of balls
 * @returns {Record<string, Float64Array[]>}
 */
export function onStrings({ contact_rows: { radial, ball } }, values, count) {
  return { radial_velocity_before: values.slice(radial, radial + count),
    radial_velocity_after: values.slice(radial + count, radial + 2 * count),
    ...(count === 2 ? { contact_ball: [values[ball]] } : {}) };
}

/**
 * Return two columns added.
 * @param {Float64Array} one
 * @param {Float64Array} other
 */
function sum(one, other) {
  const total = new Float64Array(one.length);
  for (let i = 0; i < one.length; i += 1) total[i] = one[i] + other[i];
  return total;
}

/**
 * Return how a run ended.
 * @param {Case} each
 * @param {import("../kernels/run.js").KernelRun} result
 */
function statusOf(each, { status, isOutsideModel, reached: time }) {
  if (status === "complete") return status;
  if (isOutsideModel) return sentenceOf("left_model", { time });
  return status === "failed" ? sentenceOf("left_numbers", { time })
    : sentenceOf("contact_limit", { time, limit: each.contactLimit });
}

/**
 * Return the instants up to `end` at which the drive's phase is a multiple of 2 pi [s]; none of a
 * drive without a phase, and of one that turns too often to be shown.
 * @param {Kernels} kernels
 * @param {import("../kernels/memory.js").HeldMemory} segments
 * @param {number} end
 */
function strobesOf(kernels, segments, end) {
  const turn = 2 * Math.PI;
  /** @type {number[]} */
  const instants = [];
  const get = (/** @type {string} */ name, /** @type {number} */ i) => kernels.get(segments, name, i);
  for (let i = 0; i < segments.shape[0]; i += 1) {
    const start = get("start", i);
    if (start > end || !PHASED.includes(get("form", i))) continue;
    const span = Math.min(i + 1 < segments.shape[0] ? get("start", i + 1) : end, end) - start;
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
