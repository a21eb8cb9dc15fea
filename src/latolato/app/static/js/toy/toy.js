/** A toy that moves while its parameters change: the exact integrator, a frame of time at a go. */

import { begin } from "../kernels/begin.js";
import { observe, time } from "../kernels/run.js";
import { recordOf } from "../model/case.js";
import { brokenRule } from "../model/rules.js";
import { PER_STRING } from "../model/simulate.js";
import { t } from "../strings.js";
import { ShakenDrive, SteeredDrive } from "./drive.js";
import { Minute, RATE } from "./minute.js";

/**
 * @typedef {import("../kernels/memory.js").HeldMemory} HeldMemory
 * @typedef {import("../kernels/memory.js").Kernels} Kernels
 * @typedef {import("../model/case.js").Case} Case
 * @typedef {import("../model/laws.js").System} System
 *
 * What is seen at one instant: angles and velocities, pivot and energies, in the layout's rows.
 * @typedef {{samples: Float64Array, pivot: Float64Array, out: Float64Array}} View
 */

// Aimed-at error over a few hundred periods [rad]; see `latolato.simulate`.
const TOLERANCE = 1e-10;
// A toy moves on by no more than this at a go: a hand corrects its aim as often.
export const LONGEST = 1 / 60; // s
// A hand moves no faster than this, and by this share of its way each time the toy moves on.
const HAND_SPEED = 8; // m/s
const HAND_GAIN = 0.6;
const HELD_STILL = 1e-4; // rad
// What may be set: up to so many lengths and natural frequencies.
const MOST_AMPLITUDE = 0.5;
const MOST_FREQUENCY = 40;
const MOST_DAMPING_RATIO = 2;
// Of the table of contacts; an event may need some more.
const ROOM = 256;
// Calls of the engine, and steps in one: more means that the motion cannot be followed.
const MOST_CALLS = 20;
const STEPS_PER_CALL = 10_000;
// A mode above this is sticking contact, a kind of contact below that an impact.
const FLIGHT = 0;
const REST = 2;

/** @param {number[]} values */
const largest = (values) => Math.max(...values.map(Math.abs));

/**
 * Return the least and the largest value of each control, in SI units.
 * @param {System} system
 * @returns {Record<string, [number, number]>}
 */
export function limitsOf({ balls, naturalFrequency, contacts }) {
  const longest = Math.max(...balls.map((ball) => ball.length));
  const moment = Math.min(...balls.map((ball) => ball.mass * ball.length));
  return {
    drive_amplitude: [0, MOST_AMPLITUDE * longest],
    drive_frequency: [0, MOST_FREQUENCY * naturalFrequency],
    damping: [0, MOST_DAMPING_RATIO * naturalFrequency * moment],
    ...(contacts ? { restitution: [0, 1] } : {}),
  };
}

export class Toy {
  /**
   * Throws if a control begins beyond its limits.
   * @param {Kernels} kernels of the module that runs it, for this toy alone
   * @param {Case} each
   * @param {import("./drive.js").Cosine} cosine how the pivot moves
   */
  constructor(kernels, each, cosine) {
    kernels.clear();
    this.kernels = kernels;
    this.room = ROOM + kernels.rows.spare;
    // Contact is always exact.
    this.case = { ...each, tolerance: TOLERANCE, clampStep: 0 };
    /** As it is now. */
    this.system = { ...each.system, balls: each.system.balls.map((ball) => ({ ...ball })) };
    const { balls, restitution, contacts } = this.system;
    /** What was asked for last, in SI units. @type {Record<string, number>} */
    this.controls = { drive_amplitude: cosine.amplitude, drive_frequency: cosine.frequency,
      damping: balls[0].damping, ...(contacts ? { restitution } : {}) };
    this.limits = limitsOf(this.system);
    this.check(this.controls);
    this.time = 0;
    /** Contacts since the start, and the hardest since this was last set to zero [rad/s]. */
    this.contacts = 0;
    this.clack = 0;
    /** Called with each contact: time, kind and a row of the table of contacts. */
    this.onContact = (/** @type {number} */ _time, /** @type {number} */ _kind,
      /** @type {number[]} */ _speeds) => {};
    this.minute = new Minute(kernels, cosine, this.case);
    /** @type {{ball: number, angle: number} | null} */
    this.held = null;
    this.pushed = 0;
    this.speed = 0;
    this.steered = new SteeredDrive(kernels, cosine);
    this.shaken = new ShakenDrive(kernels, this.limits.drive_amplitude[1]);
    /** The one that moves the pivot. @type {SteeredDrive | ShakenDrive} */
    this.drive = this.steered;
    this.balls = kernels.take("ball", balls.length);
    const blind = kernels.callbacks(kernels.layout.occasions.map(() => []));
    this.run = this.begin({}).run;
    kernels.set(this.run, "callbacks", blind.at);
    /** Where balls touch [rad]: of one ball the angle, of two the separation. */
    this.walls = ["low", "high"].map((name) => kernels.get(this.run, `settings.${name}`));
    this.prepare();
    const now = kernels.copy([0]);
    const samples = kernels.take("f8", kernels.rows.samples, 1);
    kernels.numbers(samples).set(this.angles.flatMap((angle, i) => [angle, this.velocities[i]]));
    balls.forEach(({ length }, i) => {
      const { distance, slack } = kernels.layout.string_rows;
      const begun = each.distances[i] ?? length;
      if (distance >= kernels.rows.samples) return;
      kernels.numbers(samples)[distance + PER_STRING * i] = begun;
      kernels.numbers(samples)[slack + PER_STRING * i] = Number(begun < length);
    });
    /** @type {View} */
    this.present = this.look(now, samples)(0);
    this.minute.add(0, this.present, this.canBegin);
    this.minute.show(0, this.present);
    kernels.release(now);
  }

  /** The angles [rad], right ball first. */
  get angles() {
    return this.state("angle");
  }

  /** The angular velocities [rad/s], right ball first. */
  get velocities() {
    return this.state("velocity");
  }

  /**
   * @param {string} name
   * @returns {number[]}
   */
  state(name) {
    const { kernels, run, system } = this;
    return [...kernels.numbers(kernels.field(run, `state.${name}`)).subarray(0, system.angles)];
  }

  /** How far the balls are from the pivot [m], right ball first. */
  get distances() {
    const { layout: { string_rows: { distance } }, rows } = this.kernels;
    return this.system.balls.map(({ length }, i) =>
      (distance < rows.samples ? this.present.samples[distance + PER_STRING * i] : length));
  }

  /** How fast the step must allow the balls to be [rad/s]: slack strings do not turn them. */
  get speeds() {
    const { kernels, run, system } = this;
    const slack = kernels.numbers(kernels.field(run, "state.is_slack"));
    const places = kernels.numbers(kernels.field(run, "state.place"));
    return this.velocities.map((velocity, i) => (slack[i]
      ? Math.hypot(places[4 * i + 2], places[4 * i + 3]) / system.balls[i].length : velocity));
  }

  /** Height [m], velocity and acceleration of the pivot. */
  get pivot() {
    const [height, velocity, acceleration] = this.present.pivot;
    return { height, velocity, acceleration };
  }

  /**
   * Take new values of controls, from now on; if one is wrong none is taken.
   * @param {Record<string, number>} values in SI units
   */
  set(values) {
    this.check(values);
    const { controls, system } = this;
    Object.assign(controls, values);
    if ("damping" in values) for (const ball of system.balls) ball.damping = values.damping;
    system.restitution = values.restitution ?? system.restitution;
    if ("damping" in values || "restitution" in values) this.noteHand();
    if (!this.isShaken && ("drive_amplitude" in values || "drive_frequency" in values)) this.steer();
    this.prepare();
  }

  /** Change the cosine of the pivot to what was asked for last. */
  steer() {
    const { controls, minute, steered, time } = this;
    steered.settle(time);
    minute.steer(steered.steer(time, controls.drive_amplitude, controls.drive_frequency));
  }

  /** Whether something else than the cosine moves the pivot. */
  get isShaken() {
    return this.drive === this.shaken;
  }

  /**
   * Let something shake the pivot from now on; null leaves it to the cosine again. Height and velocity
   * are continuous.
   * @param {import("./drive.js").Lead | null} lead
   */
  shake(lead) {
    const { controls, shaken, steered } = this;
    if (lead && this.isShaken) shaken.lead = lead;
    else if (lead) {
      shaken.begin(this.pivot, lead);
      this.drive = shaken;
    } else if (this.isShaken) {
      steered.resume(this.time, this.pivot, controls.drive_frequency, shaken.limit);
      this.minute.settle(steered.cosine);
      this.drive = steered;
      this.steer();
    } else return;
    this.prepare();
  }

  /**
   * Throw if a control is unknown or beyond its limits.
   * @param {Record<string, number>} values
   */
  check(values) {
    for (const [name, value] of Object.entries(values)) {
      if (!(name in this.limits)) throw new RangeError(`unknown control '${name}'`);
      const [low, high] = this.limits[name];
      const range = `[${low}, ${high}]`;
      if (!(typeof value === "number" && value >= low))
        throw brokenRule("at_least", { parameter: name, value }, { range, end: String(low) });
      if (value > high) throw brokenRule("at_most", { parameter: name, value }, { range, end: String(high) });
    }
  }

  /**
   * Give the ball, or both apart, an angular velocity when the toy moves on.
   * @param {number} speed in rad/s
   */
  push(speed) {
    this.pushed += speed;
  }

  /**
   * Lead a ball to an angle from now on, as a hand would; null lets go, and the ball keeps its
   * velocity.
   * @param {{ball: number, angle: number} | null} aim angle in rad
   */
  hold(aim) {
    const [low, high] = this.walls;
    this.held = aim && this.system.angles === 1
      ? { ...aim, angle: Math.min(Math.max(aim.angle, low), high) } : aim;
  }

  /**
   * Move on; throws if the motion left the range of numbers or cannot be followed.
   * @param {number} stop in s, at most `LONGEST` from now
   * @param {number} [wall] of the page's clock then [ms]
   */
  advance(stop, wall = performance.now()) {
    const { kernels, run } = this;
    if (this.isShaken) {
      this.shaken.move(this.time, stop, wall);
      this.minute.shakenAt = stop;
    } else if (this.steered.settle(this.time)) {
      this.minute.settle(this.steered.cosine);
      this.prepare();
    }
    const kick = this.kick(stop - this.time);
    const speed = largest(this.speeds) + largest(kick);
    if (speed > this.speed) this.prepare(speed);
    const isKicked = kick.some((each) => each !== 0);
    if (isKicked || this.held) this.noteHand();
    /** @type {number[]} */
    const kept = [];
    for (let k = Math.floor(this.time * RATE); k / RATE <= stop; k += 1)
      if (k / RATE > this.time) kept.push(k / RATE);
    const instants = kernels.copy(kept.at(-1) === stop ? kept : [...kept, stop]);
    const count = instants.shape[0];
    const samples = kernels.take("f8", kernels.rows.samples, count);
    const contacts = { times: kernels.take("f8", this.room), kinds: kernels.take("i8", this.room),
      values: kernels.take("f8", kernels.layout.contact_rows.count, this.room) };
    kernels.set(run, "state.sample", 0);
    kernels.set(run, "state.kick", 0);
    kernels.fill(kernels.field(run, "words"), "arguments", {
      "timetable.segments": this.drive.segments,
      "timetable.segment_changes": this.drive.segments, // not read: no derivatives are asked for
      "timetable.kick_times": kernels.copy(isKicked ? [this.time] : []),
      "timetable.kick_sizes": { ...kernels.copy(kick), shape: [kick.length, Number(isKicked)] },
      "output.sample_times": instants, "output.samples": samples,
      "output.contact_times": contacts.times, "output.contact_kinds": contacts.kinds,
      "output.contact_values": contacts.values,
      "accumulators.acc": kernels.take("f8", 1), "accumulators.column": 0, "accumulators.columns": this.system.angles,
    });
    for (let calls = 1; ; calls += 1) {
      this.noteContacts(kernels.exports.engine(run.at, stop, STEPS_PER_CALL), contacts);
      if (kernels.get(run, "state.is_outside_model")) throw new Error(t("toyBeyondModel"));
      if (time(kernels, run) >= stop) break;
      if (calls === MOST_CALLS) throw new Error(t("toyTooFast"));
    }
    if (![...this.angles, ...this.velocities].every(Number.isFinite))
      throw new Error(t("toyBeyondNumbers"));
    kernels.set(run, "state.t_base", stop);
    kernels.set(run, "state.steps", 0);
    this.time = stop;
    const viewAt = this.look(instants, samples);
    const begins = this.canBegin;
    kept.forEach((instant, i) => this.minute.add(instant, viewAt(i), begins));
    this.present = viewAt(count - 1);
    this.minute.show(stop, this.present);
    kernels.release(instants);
  }

  /**
   * Return the function that returns what is seen at one of some instants.
   * @param {HeldMemory} times
   * @param {HeldMemory} samples
   * @returns {(i: number) => View}
   */
  look(times, samples) {
    const { kernels, system, balls } = this;
    const { segments } = this.drive;
    const { pivot, out } = observe(kernels, /** @type {any} */ ({ times, segments }), samples,
      { balls, gravity: system.gravity, is_linear: system.linear, in_lab: system.drag_frame === "lab",
        with_lab: false });
    const count = times.shape[0];
    const column = (/** @type {HeldMemory} */ table, /** @type {number} */ i) => kernels.numbers(table)
      .filter((/** @type {number} */ _, /** @type {number} */ k) => k % count === i);
    return (i) => ({ samples: column(samples, i), pivot: column(pivot, i), out: column(out, i) });
  }

  /**
   * Return the record of a run that begins as the toy did, with the parameters as they are.
   * @param {Record<string, number>} more fields of the case
   */
  begin(more) {
    const fields = recordOf({ ...this.case, system: this.system }, 0);
    return begin(this.kernels, { ...fields, follows_ledger: 0, follows_tension: 0,
      ...this.drive.bounds, ...more }, this.drive.segments);
  }

  /**
   * Write what the engine reads and moving on does not change.
   * @param {number} [speed] which the step must allow for [rad/s]
   */
  prepare(speed = 0) {
    const { kernels, run, system, balls } = this;
    system.balls.forEach((ball, i) => {
      for (const [name, value] of Object.entries(ball)) kernels.numbers(kernels.field(balls, name, i))[0] = value;
    });
    this.speed = 1.5 * Math.max(largest(this.speeds), speed, system.naturalFrequency);
    const { run: fresh } = this.begin({ speed: this.speed, is_exact: 1 });
    for (const part of ["settings", "bodies"])
      kernels.bytes(kernels.field(run, part)).set(kernels.bytes(kernels.field(fresh, part)));
    kernels.set(run, "state.segment", 0);
    kernels.release(fresh);
  }

  /**
   * Return the change of each velocity that pushes and the hand make now [rad/s].
   * @param {number} span until they can change it again [s]
   */
  kick(span) {
    const kick = [this.pushed, -this.pushed].slice(0, this.system.angles);
    this.pushed = 0;
    if (!this.held) return kick;
    const { ball, angle: target } = this.held;
    const [angle, velocity] = [this.angles[ball], this.velocities[ball]];
    const away = target - angle;
    const rests = this.kernels.get(this.run, "state.mode") > FLIGHT;
    if (rests && Math.abs(away) < HELD_STILL) return kick;
    const { gravity, linear, balls, angles } = this.system;
    const { length } = balls[ball];
    let fall = -((gravity + this.pivot.acceleration) / length) * (linear ? angle : Math.sin(angle));
    // It presses the ball where it is wanted.
    if (angles === 1 && this.walls.includes(target) && fall * (target - Math.PI / 2) > 0) fall = 0;
    const fastest = HAND_SPEED / length;
    const speed = Math.min(Math.max((HAND_GAIN * away) / span, -fastest), fastest);
    kick[ball] += speed - 0.5 * fall * span - velocity;
    return kick;
  }

  /**
   * Count contacts, keep them, and remember the hardest, for the flash.
   * @param {number} rows
   * @param {Record<"times" | "kinds" | "values", HeldMemory>} contacts
   */
  noteContacts(rows, { times, kinds, values }) {
    const { kernels, minute, system } = this;
    const table = kernels.numbers(values);
    for (let i = 0; i < rows; i += 1) {
      const speeds = Array.from({ length: kernels.layout.contact_rows.count }, (_, row) =>
        table[row * this.room + i]);
      const kind = Number(kernels.numbers(kinds)[i]);
      const at = kernels.numbers(times)[i];
      minute.addContact(at, kind, speeds);
      this.onContact(at, kind, speeds);
      if (kind >= REST) continue;
      this.contacts += 1;
      const closing = system.angles === 2 ? speeds[0] - speeds[1] : 2 * speeds[0];
      this.clack = Math.max(this.clack, Math.abs(closing));
    }
  }

  /** Whether a run could begin now: its drive is steady, nobody holds a ball, and no ball has left its circle. */
  get canBegin() {
    return !this.isShaken && this.drive.isSteady && !this.held && !this.state("is_slack").some(Number);
  }

  /** Note that a hand changes something now that no run can repeat. */
  noteHand() {
    this.minute.handAt = this.time;
  }
}
