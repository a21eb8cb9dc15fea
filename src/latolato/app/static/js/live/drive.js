/** The drive of a toy: a cosine whose amplitude and frequency follow what was asked for. */

import { shake } from "../kernels/begin.js";

/**
 * @typedef {import("../kernels/memory.js").Kernels} Kernels
 * @typedef {import("../model/case.js").Case} Case
 *
 * A steady cosine with its phase at an instant, and a change to another amplitude and frequency.
 * @typedef {{start: number, amplitude: number, frequency: number, phase: number}} Cosine
 * @typedef {{time: number, amplitude: number, frequency: number, ramp: number}} Change
 */

// The least time of a change, and the acceleration that no change adds more of, so that moving a
// slider is no blow: about half of gravity.
export const SHORTEST_CHANGE = 0.05; // s
const GENTLE = 5; // m/s^2
const NO_COSINES = ["crank_slider", "measured_pivot"];

/**
 * Return the cosine that the drive of a case begins with.
 * @param {Case} each
 * @returns {Cosine}
 */
export function cosineOf({ drive: { kind, parameters }, system }) {
  const { drive_amplitude, drive_amplitudes, drive_frequency, drive_frequencies, drive_phase,
    pivot_heights: heights = [0] } = /** @type {Record<string, any>} */ (parameters);
  return {
    start: 0,
    amplitude: drive_amplitude ?? drive_amplitudes?.[0]
      ?? 0.5 * (Math.max(...heights) - Math.min(...heights)),
    frequency: drive_frequency ?? drive_frequencies?.[0] ?? 2 * system.naturalFrequency,
    phase: drive_phase ?? 0,
  };
}

/**
 * Return whether a kind of drive rests or moves as a cosine, whose amplitude and frequency may vary.
 * @param {string} kind
 */
export const isByCosine = (kind) => !NO_COSINES.includes(kind);

/**
 * Return the parameters of a `StagedHarmonic` whose time begins where the cosine does.
 * @param {Cosine} cosine
 * @param {Change[]} changes
 */
export function stagesOf(cosine, changes) {
  const all = [{ ...cosine, time: cosine.start, ramp: 1 }, ...changes];
  return {
    times: all.map(({ time }) => time - cosine.start),
    drive_amplitudes: all.map(({ amplitude }) => amplitude),
    drive_frequencies: all.map(({ frequency }) => frequency),
    ramps: all.map(({ ramp }) => ramp),
    drive_phase: cosine.phase,
  };
}

export class SteeredDrive {
  /**
   * @param {Kernels} kernels
   * @param {Cosine} cosine
   */
  constructor(kernels, cosine) {
    this.kernels = kernels;
    this.cosine = cosine;
    /** Those that have not ended, and others before them. @type {Change[]} */
    this.changes = [];
    /** One stretch, or a change and what follows it. */
    this.stretches = kernels.take("stretch", 2);
    this.write();
  }

  /** Whether no change is under way. */
  get isSteady() {
    return this.changes.length === 0;
  }

  /**
   * Return the cosine with another start, a steady one.
   * @param {number} start
   * @returns {Cosine}
   */
  from(start) {
    const { phase, frequency, start: before } = this.cosine;
    return { ...this.cosine, start, phase: (phase + frequency * (start - before)) % (2 * Math.PI) };
  }

  /**
   * Change from an instant on, smoothly; of several changes at one instant the last counts.
   * @param {number} time
   * @param {number} amplitude
   * @param {number} frequency
   * @returns {Change}
   */
  steer(time, amplitude, frequency) {
    const { kernels, changes, stretches } = this;
    if (changes.at(-1)?.time === time) changes.pop();
    // No stage lasts no time.
    if (this.cosine.start === time) this.cosine = this.from(time - 1);
    const change = { time, amplitude, frequency, ramp: 1 };
    changes.push(change);
    this.write(); // only to know what it does now
    const [now, turning] = ["c0", "frequency"].map((name) => kernels.get(stretches, name));
    const turn = Math.max(amplitude, Math.abs(now)) * Math.abs(frequency - turning);
    change.ramp = Math.max(SHORTEST_CHANGE, Math.sqrt((6 * Math.abs(amplitude - now)) / GENTLE),
      turn / GENTLE);
    this.write();
    return change;
  }

  /**
   * Forget the changes that have ended by an instant; returns whether there were any.
   * @param {number} time
   */
  settle(time) {
    const last = (/** @type {string} */ name) => this.kernels.get(this.stretches, name, 1);
    if (this.isSteady || time < last("start")) return false;
    this.cosine = { start: last("start"), amplitude: last("c0"), frequency: last("frequency"),
      phase: last("phase") };
    this.changes = [];
    this.write();
    return true;
  }

  /** Write the stretches; the compiled code knows how a change goes. */
  write() {
    const { kernels, cosine, changes, stretches } = this;
    const all = shake(kernels, "staged_harmonic", stagesOf(cosine, changes));
    stretches.shape = [changes.length ? 2 : 1];
    const first = (all.shape[0] - stretches.shape[0]) * kernels.size("stretch");
    kernels.bytes(stretches).set(kernels.bytes(all).subarray(first));
    const { numbers, step } = kernels.column(stretches, "start");
    for (let i = 0; i < numbers.length; i += step) numbers[i] += cosine.start;
    kernels.release(all);
  }
}
