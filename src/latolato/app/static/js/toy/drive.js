/**
 * The drives of a toy: a cosine whose amplitude and frequency follow what was asked for, and a pivot
 * that a phone or a hand shakes.
 */

import { shake } from "../kernels/begin.js";

/**
 * @typedef {import("../kernels/memory.js").HeldMemory} HeldMemory
 * @typedef {import("../kernels/memory.js").Kernels} Kernels
 * @typedef {import("../model/case.js").Case} Case
 *
 * A steady cosine with its phase at an instant, and a change to another amplitude and frequency.
 * @typedef {{start: number, amplitude: number, frequency: number, phase: number}} Cosine
 * @typedef {{time: number, amplitude: number, frequency: number, ramp: number}} Change
 *
 * Height [m], velocity and acceleration of the pivot.
 * @typedef {{height: number, velocity: number, acceleration: number}} Pivot
 *
 * What shakes a pivot: `at` returns the acceleration that it adds [m/s^2] and the height that it
 * leads to [m] at an instant of the page's clock [ms]. The pivot is drawn there as by a spring of
 * this angular frequency [rad/s] and damping ratio.
 * @typedef {{rate: number, dampingRatio: number,
 *   at: (wall: number) => {acceleration: number, height: number}}} Lead
 */

// The least time of a change, and the acceleration that no change adds more of, so that moving a
// slider is no blow: about half of gravity.
export const SHORTEST_CHANGE = 0.05; // s
const GENTLE = 5; // m/s^2
// Phones measure up to eight times gravity, and so much is passed on.
export const MOST_ACCELERATION = 80; // m/s^2
// The spring of a lead begins stiff and softens to its own rate, so that what the pivot did before, and
// the unknown speed of what shakes it, are soon forgotten. It stiffens while the pivot is braked.
const FIRST_RATE = 15; // rad/s
const SOFTENING = 1; // s
const STIFFENING = 0.1; // s
// A pivot that needs this deceleration to stop before its largest height is braked; from half of it on
// gradually, so that it does not rattle.
const BRAKE = 30; // m/s^2
// Forms of segments, at rest and a polynomial; see `latolato.physics.drives.segment`.
const STILL = 0;
const POLYNOMIAL = 4;

/**
 * Return the cosine that the drive of a case begins with.
 * @param {Case} each
 * @returns {Cosine}
 */
export function cosineOf({ kernels, drive: { kind, parameters }, system }) {
  const segments = shake(kernels, kind, parameters);
  const [form, amplitude, frequency, phase] = ["form", "c0", "frequency", "phase"].map((name) =>
    kernels.get(segments, name));
  kernels.release(segments);
  return { start: 0, amplitude, phase,
    frequency: form === STILL ? 2 * system.naturalFrequency : frequency };
}

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
    /** One segment, or a change and what follows it. */
    this.segments = kernels.take("segment", 2);
    /** What the step of a run is chosen by, where it is not found from the segments. */
    this.bounds = {};
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
   * Take over a pivot that moved otherwise: by a cosine that has its height and velocity.
   * @param {number} time
   * @param {Pivot} pivot
   * @param {number} frequency that it has if the cosine's amplitude stays within the limit
   * @param {number} limit of the amplitude [m]
   */
  resume(time, { height, velocity }, frequency, limit) {
    const room = Math.sqrt(Math.max(limit * limit - height * height, (0.1 * limit) ** 2));
    const fast = Math.max(frequency, Math.abs(velocity) / room);
    const across = fast > 0 ? -velocity / fast : 0;
    this.cosine = { start: time, amplitude: Math.hypot(height, across), frequency: fast,
      phase: Math.atan2(across, height) };
    this.changes = [];
    this.write();
  }

  /**
   * Change from an instant on, smoothly; of several changes at one instant the last counts.
   * @param {number} time
   * @param {number} amplitude
   * @param {number} frequency
   * @returns {Change}
   */
  steer(time, amplitude, frequency) {
    const { kernels, changes, segments } = this;
    if (changes.at(-1)?.time === time) changes.pop();
    // No stage lasts no time.
    if (this.cosine.start === time) this.cosine = this.from(time - 1);
    const change = { time, amplitude, frequency, ramp: 1 };
    changes.push(change);
    this.write(); // only to know what it does now
    const [now, turning] = ["c0", "frequency"].map((name) => kernels.get(segments, name));
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
    const last = (/** @type {string} */ name) => this.kernels.get(this.segments, name, 1);
    if (this.isSteady || time < last("start")) return false;
    this.cosine = { start: last("start"), amplitude: last("c0"), frequency: last("frequency"),
      phase: last("phase") };
    this.changes = [];
    this.write();
    return true;
  }

  /** Write the segments; the compiled code knows how a change goes. */
  write() {
    const { kernels, cosine, changes, segments } = this;
    const all = shake(kernels, "staged_harmonic", stagesOf(cosine, changes));
    segments.shape = [changes.length ? 2 : 1];
    const first = (all.shape[0] - segments.shape[0]) * kernels.size("segment");
    kernels.bytes(segments).set(kernels.bytes(all).subarray(first));
    const { numbers, step } = kernels.column(segments, "start");
    for (let i = 0; i < numbers.length; i += step) numbers[i] += cosine.start;
    kernels.release(all);
  }
}

/**
 * A pivot that is shaken. Its acceleration is linear between the instants to which the toy moves on,
 * and height and velocity are the exact integrals of that.
 */
export class ShakenDrive {
  /**
   * @param {Kernels} kernels
   * @param {number} limit of the height, up and down [m]
   */
  constructor(kernels, limit) {
    this.kernels = kernels;
    this.limit = limit;
    this.segments = kernels.take("segment", 1);
    this.bounds = { pivot_bound: MOST_ACCELERATION, drive_rate: 0 };
    /** @type {Pivot} */
    this.pivot = { height: 0, velocity: 0, acceleration: 0 };
    /** @type {Lead | null} */
    this.lead = null;
    /** How much faster than the lead's the spring is [rad/s]. */
    this.excess = 0;
    /** Whether the limits cut off a part of the shaking since this was last set to false. */
    this.isLimited = false;
  }

  get isSteady() {
    return true;
  }

  /**
   * Take over a pivot.
   * @param {Pivot} pivot
   * @param {Lead} lead
   */
  begin(pivot, lead) {
    this.excess = Math.max(FIRST_RATE - lead.rate, 0);
    this.pivot = pivot;
    this.lead = lead;
    this.isLimited = false;
    // A cosine may be faster than any shaking; it is stopped with what it takes.
    this.bounds.pivot_bound = Math.max(MOST_ACCELERATION, Math.abs(pivot.acceleration),
      pivot.velocity ** 2 / this.limit);
  }

  /**
   * Write how the pivot moves from one instant to another.
   * @param {number} time
   * @param {number} stop
   * @param {number} wall of the page's clock at `stop` [ms]
   */
  move(time, stop, wall) {
    const { kernels, segments, pivot: { height, velocity, acceleration } } = this;
    const span = stop - time;
    const next = this.wish(span, wall);
    const bend = (next - acceleration) / (6 * span);
    const numbers = { start: time, form: POLYNOMIAL, c0: height, c1: velocity,
      c2: 0.5 * acceleration, c3: bend };
    for (const [name, value] of Object.entries(numbers)) kernels.set(segments, name, value);
    this.pivot = {
      height: height + span * (velocity + span * (0.5 * acceleration + span * bend)),
      velocity: velocity + 0.5 * span * (acceleration + next),
      acceleration: next,
    };
  }

  /**
   * Return the acceleration at the end of a span: that of the lead and of its spring, within the
   * limits. The spring acts on the height and velocity there, which depend on the acceleration.
   * @param {number} span
   * @param {number} wall
   */
  wish(span, wall) {
    const lead = /** @type {Lead} */ (this.lead);
    const { height, velocity, acceleration } = this.pivot;
    const rate = lead.rate + this.excess;
    const [stiffness, drag] = [rate ** 2, 2 * (lead.dampingRatio * lead.rate + this.excess)];
    // At the end, but for what its acceleration adds.
    const there = height + span * (velocity + (span * acceleration) / 3);
    const speed = velocity + 0.5 * span * acceleration;
    const aim = lead.at(wall);
    const goal = Math.min(Math.max(aim.height, -this.limit), this.limit);
    if (goal !== aim.height) this.isLimited = true;
    const wish = (aim.acceleration + stiffness * (goal - there) - drag * speed)
      / (1 + 0.5 * span * drag + (span * span * stiffness) / 6);
    return this.limited(wish, there, speed, span);
  }

  /**
   * Return an acceleration that is within the limits and stops the pivot before its largest height.
   * @param {number} wish
   * @param {number} height
   * @param {number} velocity
   * @param {number} span until the next one
   */
  limited(wish, height, velocity, span) {
    const most = this.bounds.pivot_bound;
    const away = Math.sign(velocity);
    const left = Math.max(this.limit - away * height, 0);
    const speed = Math.abs(velocity);
    // Not so much that it would turn the pivot round.
    const needed = Math.min(speed / span, speed ** 2 / Math.max(2 * left, 1e-9));
    const share = Math.min(Math.max((2 * needed) / BRAKE - 1, 0), 1);
    const braked = wish + share * Math.min(-needed - away * wish, 0) * away;
    const result = Math.min(Math.max(braked, -most), most);
    if (result !== wish) this.isLimited = true;
    this.soften(span, result !== wish);
    return result;
  }

  /**
   * @param {number} span
   * @param {boolean} isBraked whether the spring stiffens instead
   */
  soften(span, isBraked) {
    const { rate } = /** @type {Lead} */ (this.lead);
    const [goal, time] = isBraked ? [Math.max(FIRST_RATE - rate, 0), STIFFENING] : [0, SOFTENING];
    this.excess += Math.min(span / time, 1) * (goal - this.excess);
  }
}
