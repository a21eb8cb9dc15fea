/** Samples and contacts of a live motion, and the changes of its drive. */

import { blockOf } from "../model/block.js";
import { LEDGER, onStrings, PER_STRING, run } from "../model/simulate.js";
import { t } from "../strings.js";
import { stagesOf } from "./drive.js";

/**
 * @typedef {import("../kernels/memory.js").Kernels} Kernels
 * @typedef {import("../model/case.js").Case} Case
 * @typedef {import("../model/simulate.js").Run} Run
 * @typedef {import("./drive.js").Cosine} Cosine
 * @typedef {import("./drive.js").Change} Change
 */

export const MOST_SECONDS = 300;
// A run that is computed again and stays this close to what was seen is that run.
export const SAME = 1e-6; // rad
// What is known of a run that was computed in one go, but not of a recording.
const OF_RUNS = ["scenario", "energy_residual", "step", "step_halvings", "grazing_contacts",
  "compression_time", "compression_fraction", "first_slack", "slack_fraction", "largest_string_impulse"];

/** Rows of numbers, as many as come. */
class Table {
  /** @param {number} width of a row */
  constructor(width) {
    this.width = width;
    this.size = 0;
    this.numbers = new Float64Array(256 * width);
  }

  /** @param {number[]} row */
  add(row) {
    const end = this.size * this.width;
    if (end === this.numbers.length) {
      const before = this.numbers;
      this.numbers = new Float64Array(2 * end);
      this.numbers.set(before);
    }
    this.numbers.set(row, end);
    this.size += 1;
  }

  /** @param {number} place in each row */
  column(place) {
    return Float64Array.from({ length: this.size }, (_, i) => this.numbers[i * this.width + place]);
  }
}

export class Recording {
  /**
   * @param {Pick<Kernels, "layout" | "rows">} kernels
   * @param {Cosine} cosine the drive, from the beginning on
   * @param {Case} each system and start, which other drives do not change
   */
  constructor({ layout, rows }, cosine, each) {
    this.layout = layout;
    this.rows = rows;
    this.cosine = cosine;
    this.case = each;
    /** Whether anything but the drive was changed: a push, a drag, damping or restitution. */
    this.byHand = false;
    /** Whether the pivot was shaken, which no drive has parameters for. */
    this.isShaken = false;
    /** @type {Change[]} */
    this.changes = [];
    this.samples = new Table(1 + rows.samples + rows.pivot.length
      + each.system.angles * layout.ball_rows.length);
    this.contacts = new Table(2 + layout.contact_rows.count);
  }

  /** How long it is by now [s]. */
  get duration() {
    const { numbers, size, width } = this.samples;
    return numbers[(size - 1) * width];
  }

  get isFull() {
    return this.duration >= MOST_SECONDS;
  }

  /**
   * Keep a sample.
   * @param {number} time on the clock of the toy [s]
   * @param {import("./toy.js").View} view
   */
  add(time, { samples, pivot, out }) {
    this.samples.add([time - this.cosine.start, ...samples, ...pivot, ...out]);
  }

  /**
   * Keep a contact.
   * @param {number} time
   * @param {number} kind
   * @param {number[]} speeds its row of the table of contacts
   */
  addContact(time, kind, speeds) {
    this.contacts.add([time - this.cosine.start, kind, ...speeds]);
  }

  /**
   * Keep a change of the drive; of several at one instant the last counts.
   * @param {Change} change
   */
  steer(change) {
    if (this.changes.at(-1)?.time === change.time) this.changes.pop();
    this.changes.push(change);
  }

  /**
   * Return the drive, whose time begins with the recording; the heights of a shaken pivot are columns.
   * @returns {import("../model/laws.js").Drive}
   */
  drive() {
    if (this.isShaken) return { kind: "measured_pivot", moves: true, parameters: {} };
    const { amplitude, frequency, phase } = this.cosine;
    return this.changes.length
      ? { kind: "staged_harmonic", moves: true, parameters: stagesOf(this.cosine, this.changes) }
      : { kind: "harmonic", moves: true, parameters: { drive_amplitude: amplitude,
        drive_frequency: frequency, drive_phase: phase } };
  }

  /**
   * Return the options of the run that has this start and this drive, in SI units.
   * @returns {Record<string, any>}
   */
  options() {
    const { registry, system, contact, restSpeed, angles, velocities } = this.case;
    const own = registry.systems[system.kind].options.map((name) => {
      const [, side, part] = /** @type {string[]} */ (/^(right_|left_)?(.*)$/.exec(name));
      const ball = /** @type {any} */ (system.balls[side === "left_" ? 1 : 0]);
      return [name, part in ball ? ball[part] : /** @type {any} */ (system)[name]];
    });
    const { kind, parameters: { times, ...others } } = /** @type {any} */ (this.drive());
    const each = (/** @type {number[]} */ values) => (values.length > 1 ? values : values[0]);
    return { system: system.kind, ...Object.fromEntries(own), drive: kind,
      ...(times ? { drive_times: times } : {}), ...others, initial_angle: each(angles),
      initial_angular_velocity: each(velocities), duration: this.duration,
      contact: contact === "none" ? "none" : "exact", rest_speed: restSpeed };
  }

  /**
   * Return the case of the same start and drive, at the same instants.
   * @returns {Case}
   */
  whole() {
    return { ...this.case, options: this.options(), drive: this.drive(), offset: null,
      times: this.samples.column(0), duration: this.duration };
  }

  /** Return the run of the same start and drive; null where the pivot was shaken. */
  again() {
    return this.isShaken ? null : run(this.whole());
  }

  /**
   * Return whether this is the run of its options.
   * @param {Run | null} again
   */
  isRun(again) {
    return again !== null && !this.byHand && this.deviation(again) <= SAME;
  }

  /**
   * Return how far [rad] a run is from what was recorded.
   * @param {Run} again
   */
  deviation({ columns }) {
    const gaps = columns.angle.flatMap((angles, ball) => {
      const seen = this.samples.column(1 + 2 * ball);
      return Array.from(angles, (angle, i) => Math.abs(angle - seen[i]));
    });
    return gaps.reduce((most, gap) => Math.max(most, gap), 0);
  }

  /**
   * The recorded samples by name: one column, or one for each ball.
   * @returns {Record<string, Float64Array[]>}
   */
  columns() {
    const { sample_rows, string_rows, ball_rows } = this.layout;
    const { angles, linear, suspension } = this.case.system;
    const isString = suspension === "string";
    const pivot = 1 + this.rows.samples;
    const out = pivot + this.rows.pivot.length;
    const each = (/** @type {(ball: number) => number} */ place) =>
      Array.from({ length: angles }, (_, ball) => this.samples.column(place(ball)));
    const ofBalls = (/** @type {string} */ name) =>
      each((ball) => out + ball * ball_rows.length + ball_rows.indexOf(name));
    const [kinetic, potential] = ["kinetic_energy", "potential_energy"].map(ofBalls);
    /** @type {Record<string, Float64Array[]>} */
    const columns = {
      time: [this.samples.column(0)],
      angle: each((ball) => 1 + 2 * ball), angular_velocity: each((ball) => 2 + 2 * ball),
      ...(isString ? Object.fromEntries(Object.entries(string_rows).map(([name, row]) =>
        [name, each((ball) => 1 + row + PER_STRING * ball)])) : {}),
      ...Object.fromEntries(this.rows.pivot.map((name, i) => [name, [this.samples.column(pivot + i)]])),
      kinetic_energy: kinetic, potential_energy: potential,
      total_energy: kinetic.map((row, ball) => row.map((value, i) => value + potential[ball][i])),
      drive_power: ofBalls("drive_power"), damping_power: ofBalls("damping_power"),
    };
    if (!linear) columns.tension = ofBalls("tension"); // the small-angle model has none
    for (const name of LEDGER)
      if (name !== "retension_loss" || isString) columns[name] = [this.samples.column(1 + sample_rows[name])];
    if (columns.noise_work[0].every((work) => work === 0)) delete columns.noise_work;
    return columns;
  }

  /**
   * The recorded contacts by name; kinds are numbers of the layout's.
   * @returns {Record<string, Float64Array[]>}
   */
  contactColumns() {
    const { angles, suspension } = this.case.system;
    const each = (/** @type {number} */ first) =>
      Array.from({ length: angles }, (_, ball) => this.contacts.column(first + ball));
    const values = Array.from({ length: this.layout.contact_rows.count }, (_, row) => this.contacts.column(2 + row));
    return {
      contact_time: [this.contacts.column(0)], contact_kind: [this.contacts.column(1)],
      angular_velocity_before: each(2), angular_velocity_after: each(2 + angles),
      ...(suspension === "string" ? onStrings(this.layout, values, angles) : {}),
    };
  }

  /**
   * The recording as a block, as Play shows runs.
   * @param {Run | null} again
   */
  block(again) {
    const { time: [time], ...columns } = this.columns();
    const { contact_time, contact_kind, angular_velocity_before: before,
      angular_velocity_after: after, ...others } = this.contactColumns();
    const unknown = { case: this.whole(), strobes: new Float64Array(0), energyResidual: NaN, step: NaN,
      halvings: 0, grazes: 0, pulls: {} };
    const block = blockOf({ ...again ?? unknown, time, columns, warnings: [], status: "complete",
      contacts: { time: contact_time[0], kind: Uint8Array.from(contact_kind[0]), before, after, others } });
    const { about } = block;
    for (const name of OF_RUNS) delete about.attributes[name];
    const notes = [this.isShaken && t("recordedShakenNote"), this.byHand && t("recordedHandNote")];
    about.attributes.note = notes.filter(Boolean).join("; ") || t("recordedNote");
    const note = this.isShaken ? "recordedShaken" : this.byHand ? "recordedHand"
      : this.isRun(again) ? "recordedExact" : "recordedChaos";
    return { ...block, about: { ...about, by_hand: this.byHand, python: "", command: "", note: t(note) } };
  }
}
