/** Runs of one ball and of two from their prepared beginning, as `latolato.numerics.integrate`. */

import { WORD } from "./memory.js";

/**
 * @typedef {import("./memory.js").HeldMemory} HeldMemory
 * @typedef {import("./memory.js").Kernels} Kernels
 */

/**
 * A run at its beginning: the record with its state, settings, bodies and stepper, the drive's
 * segments, kicks, and the instants of the samples; see `begin` and `loop.Timetable`.
 * @typedef {{run: HeldMemory, segments: HeldMemory, kick_times: HeldMemory, kick_sizes: HeldMemory,
 *   times: HeldMemory}} Prepared
 *
 * What came of it. Rows of samples are those of the layout, behind angle and velocity of two balls;
 * kinds of contacts are numbers of those in the layout, their values the velocities before and
 * after, of all balls, and behind them what the layout's rows of contacts say. A motion that is not
 * described is outside the model.
 * @typedef {{status: "complete" | "failed" | "stopped", isOutsideModel: boolean, reached: number,
 *   samples: HeldMemory, contacts: {times: Float64Array, kinds: Float64Array, values: Float64Array[]}}} KernelRun
 */

// Of the table of contacts: what it has room for at first and at most. An event may need some more.
const ROOM = 256;
const MOST_ROOM = 65536;
// Of the samples: an angle and its velocity for each ball.
const PER_BALL = 2;

/**
 * The run of one ball or two; `integrate.integrate` does the same.
 * @param {Kernels} kernels
 * @param {Prepared} prepared
 * @param {{balls: number, duration: number, contact_limit: number, engine?: string}} how
 *   `engine` is `engine` or `clamp`
 * @returns {KernelRun}
 */
export function integrate(kernels, prepared, { balls, duration, contact_limit, engine = "engine" }) {
  const { layout } = kernels;
  const { run, times, segments, kick_times, kick_sizes } = prepared;
  const samples = kernels.take("f8", kernels.rows.samples, times.shape[0]);
  kernels.numbers(samples).fill(NaN);
  const seen = kernels.take("f8", 1);
  const blind = kernels.callbacks(layout.occasions.map(() => []));
  kernels.set(run, "callbacks", blind.at);
  /** @type {Float64Array[][]} times, kinds and values of contacts, as they come */
  const parts = Array.from({ length: 2 + layout.contact_rows.count }, () => []);
  let contacts = 0;
  let room = ROOM;
  let reached = -1;
  const isOutsideModel = () => kernels.get(run, "state.is_outside_model") !== 0;
  /** @type {(status: KernelRun["status"]) => KernelRun} */
  const ended = (status) => {
    const [instants, kinds, ...values] = parts.map(concatenated);
    return { status, isOutsideModel: isOutsideModel(), reached: Math.min(reached, duration), samples,
      contacts: { times: instants, kinds, values } };
  };
  for (;;) {
    const size = Math.min(room, contact_limit - contacts) + kernels.rows.spare;
    const buffer = kernels.take("f8", size);
    const kinds = kernels.take("i8", size);
    const values = kernels.take("f8", parts.length - 2, size);
    // Pages ask for no derivatives, so nothing reads how segments change.
    kernels.fill(kernels.field(run, "words"), "arguments", {
      "timetable.segments": segments, "timetable.kick_times": kick_times,
      "timetable.kick_sizes": kick_sizes, "timetable.segment_changes": segments,
      "output.sample_times": times, "output.samples": samples, "output.contact_times": buffer,
      "output.contact_kinds": kinds, "output.contact_values": values,
      "accumulators.acc": seen, "accumulators.column": 0, "accumulators.columns": balls,
    });
    const written = kernels.exports[engine](run.at, duration, layout.steps_per_call);
    parts[0].push(kernels.numbers(buffer).slice(0, written));
    parts[1].push(Float64Array.from(kernels.numbers(kinds).subarray(0, written), Number));
    const rows = kernels.numbers(values);
    for (let i = 2; i < parts.length; i += 1) {
      parts[i].push(rows.slice((i - 2) * size, (i - 2) * size + written));
    }
    kernels.release(buffer);
    contacts += written;
    const before = reached;
    reached = time(kernels, run);
    if (reached <= before && written === 0 && Number.isFinite(reached)) {
      throw new Error(`the integration came to a halt at t = ${reached} s`);
    }
    const state = ["state.angle", "state.velocity"]
      .flatMap((name) => [...kernels.numbers(kernels.field(run, name))]);
    if (!state.every((value) => Math.abs(value) <= layout.largest)) {
      const lost = forget(kernels, samples, balls);
      if (lost >= 0) reached = kernels.numbers(times)[lost];
      return ended("failed");
    }
    if (isOutsideModel()) return ended("stopped");
    if (reached >= duration) return ended("complete");
    if (contacts >= contact_limit) return ended("stopped");
    room = Math.min(Math.max(room, 2 * written), MOST_ROOM);
  }
}

/**
 * Return arrays as one.
 * @param {Float64Array[]} parts
 */
function concatenated(parts) {
  const whole = new Float64Array(parts.reduce((size, part) => size + part.length, 0));
  let at = 0;
  for (const part of parts) {
    whole.set(part, at);
    at += part.length;
  }
  return whole;
}

/**
 * Return the time that a run has reached [s].
 * @param {Kernels} kernels
 * @param {HeldMemory} run
 */
export function time(kernels, run) {
  const steps = kernels.get(run, "state.steps");
  return kernels.get(run, "state.t_base") + steps * kernels.get(run, "settings.step");
}

/**
 * Make NaN of the samples from the first on that is out of range, and return its place or -1.
 * @param {Kernels} kernels
 * @param {HeldMemory} samples
 * @param {number} balls
 */
function forget(kernels, samples, balls) {
  const [rows, size] = samples.shape;
  const values = kernels.numbers(samples);
  for (let i = 0; i < size; i += 1) {
    for (let row = 0; row < PER_BALL * balls; row += 1) {
      if (Math.abs(values[row * size + i]) <= kernels.layout.largest) continue;
      for (let each = 0; each < rows; each += 1) values.fill(NaN, each * size + i, (each + 1) * size);
      return i;
    }
  }
  return -1;
}

/**
 * Return the pivot's motion and the balls' energies and tensions at the samples of a run; rows are
 * those of the layout. See `derived.Observation`.
 * @param {Kernels} kernels
 * @param {Prepared} prepared
 * @param {HeldMemory} samples
 * @param {{balls: HeldMemory, gravity: number, is_linear?: boolean, in_lab?: boolean,
 *   with_lab: boolean}} how
 * @returns {{pivot: HeldMemory, out: HeldMemory}}
 */
export function observe(kernels, prepared, samples, how) {
  const { times, segments } = prepared;
  const { balls, gravity, is_linear = false, in_lab = false, with_lab } = how;
  const { ball_rows, sample_rows } = kernels.layout;
  const [size] = times.shape;
  const pivot = kernels.take("f8", kernels.rows.pivot.length, size);
  const out = kernels.take("f8", balls.shape[0], ball_rows.length, size);
  const modes = { ...times, at: samples.at + sample_rows.mode * size * WORD };
  kernels.call("observer", "observation", {
    times, modes, samples, segments, balls, gravity, is_linear: Number(is_linear),
    in_lab: Number(in_lab), with_lab: Number(with_lab), pivot, out,
  });
  return { pivot, out };
}
