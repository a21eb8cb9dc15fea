/** The last minute of a toy that a hand holds: samples, contacts, and what changed its drive. */

import { blockOf } from "../model/run_block.js";
import { LEDGER, onStrings, PER_STRING, run } from "../model/simulate.js";
import { firstWhere } from "../player/motion.js";
import { t } from "../strings.js";
import { stagesOf } from "./drive.js";

/**
 * @typedef {import("../kernels/memory.js").Kernels} Kernels
 * @typedef {import("../model/case.js").Case} Case
 * @typedef {import("../model/simulate.js").Run} Run
 * @typedef {import("./drive.js").Cosine} Cosine
 * @typedef {import("./drive.js").Change} Change
 */

/** So much is remembered [s]. */
export const SPAN = 60;
/** Samples in a second. */
export const RATE = 240;
// A run that is computed again and stays this close to what was seen is that run.
export const SAME = 1e-6; // rad
// Contacts that are remembered at most: a ball that chatters makes hundreds a second.
const MOST_CONTACTS = 50_000;
// What is known of a run that was computed in one go, but not of what was played.
const OF_RUNS = ["scenario", "energy_residual", "step", "step_halvings", "grazing_contacts",
  "compression_time", "compression_fraction", "first_slack", "slack_fraction", "largest_string_impulse"];

/**
 * Keep a row; the oldest are forgotten when there are twice as many as are kept for sure.
 * @param {number[][]} rows
 * @param {number[]} row
 * @param {number} most that are kept for sure
 */
function keepRow(rows, row, most) {
  if (rows.length >= 2 * most) rows.splice(0, most);
  rows.push(row);
}

/**
 * Return one number of each row.
 * @param {number[][]} rows
 * @param {number} place in the row
 * @param {number} [first] row
 * @param {number} [stride] from a row to the next one
 */
function takeColumn(rows, place, first = 0, stride = 1) {
  const values = new Float64Array(Math.max(0, Math.ceil((rows.length - first) / stride)));
  for (let i = 0; i < values.length; i += 1) values[i] = rows[first + i * stride][place];
  return values;
}

/**
 * Return the first row that is not before an instant.
 * @param {number[][]} rows
 * @param {number} time
 */
const rowFrom = (rows, time) => firstWhere(rows.length, (i) => rows[i][TIME] >= time);

// The first numbers of a row of samples: its time, and whether a run could begin there.
const TIME = 0;
const BEGINS = 1;
const FIRST = 2;

export class Minute {
  /**
   * @param {Pick<Kernels, "layout" | "rows">} kernels
   * @param {Cosine} cosine the drive at the beginning
   * @param {Case} each system and start
   */
  constructor({ layout, rows }, cosine, each) {
    this.layout = layout;
    this.case = each;
    /** Steady cosines, each from its start on, until a change. */
    this.cosines = [cosine];
    /** @type {Change[]} */
    this.changes = [];
    /** When anything but the drive was changed last: a push, a drag, damping or restitution. */
    this.handAt = -Infinity;
    /** When the pivot was shaken last, which no drive has parameters for. */
    this.shakenAt = -Infinity;
    const { angles, linear, suspension } = each.system;
    const { sample_rows, string_rows, ball_rows } = layout;
    const isString = suspension === "string";
    const pivot = FIRST + rows.samples;
    const out = pivot + rows.pivot.length;
    const ofEach = (/** @type {(ball: number) => number} */ place) => Array.from({ length: angles }, (_, ball) => place(ball));
    const ofBalls = (/** @type {string} */ name) => ofEach((ball) => out + ball * ball_rows.length + ball_rows.indexOf(name));
    /** Where each quantity stands in a row, of each ball that has its own. @type {Record<string, number[]>} */
    this.places = {
      time: [TIME],
      angle: ofEach((ball) => FIRST + 2 * ball), angular_velocity: ofEach((ball) => FIRST + 1 + 2 * ball),
      ...(isString ? Object.fromEntries(Object.entries(string_rows).map(([name, row]) =>
        [name, ofEach((ball) => FIRST + row + PER_STRING * ball)])) : {}),
      ...Object.fromEntries(rows.pivot.map((name, i) => [name, [pivot + i]])),
      ...Object.fromEntries(["kinetic_energy", "potential_energy", "drive_power", "damping_power",
        ...(linear ? [] : ["tension"])].map((name) => [name, ofBalls(name)])), // the small-angle model has no tension
    };
    /** Those that add up from the beginning on. @type {Record<string, number[]>} */
    this.ledger = Object.fromEntries(LEDGER.filter((name) => name !== "retension_loss" || isString)
      .map((name) => [name, [FIRST + sample_rows[name]]]));
    /** The newest instant, which need not be that of a sample: a row like those. @type {number[]} */
    this.now = [];
    /** @type {number[][]} */
    this.samples = [];
    /** Time, kind and a row of the table of contacts. @type {number[][]} */
    this.contacts = [];
  }

  /** The last instant [s]. */
  get end() {
    return this.samples[this.samples.length - 1][TIME];
  }

  /**
   * Keep a sample.
   * @param {number} time
   * @param {import("./toy.js").View} view
   * @param {boolean} begins whether a run of the same motion could begin here: its drive is a steady cosine,
   *   nobody holds a ball, and none has left its circle
   */
  add(time, { samples, pivot, out }, begins) {
    keepRow(this.samples, [time, Number(begins), ...samples, ...pivot, ...out], SPAN * RATE);
  }

  /**
   * Note the newest instant.
   * @param {number} time
   * @param {import("./toy.js").View} view
   */
  show(time, { samples, pivot, out }) {
    this.now = [time, 0, ...samples, ...pivot, ...out];
  }

  /**
   * Keep a contact.
   * @param {number} time
   * @param {number} kind
   * @param {number[]} speeds its row of the table of contacts
   */
  addContact(time, kind, speeds) {
    keepRow(this.contacts, [time, kind, ...speeds], MOST_CONTACTS);
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
   * Keep the cosine that the drive is from now on, until it is changed.
   * @param {Cosine} cosine
   */
  settle(cosine) {
    this.cosines.push(cosine);
  }

  /**
   * Return one quantity of the last seconds up to now; null if it has no place.
   * @param {string} name
   * @param {number} ball
   * @param {number} seconds
   * @param {number} stride of samples: every so manieth
   */
  recent(name, ball, seconds, stride) {
    const { samples } = this;
    // Always the same ones, so that a curve does not tremble: whole strides were forgotten.
    const first = stride * Math.ceil(rowFrom(samples, this.end - seconds) / stride);
    const own = (/** @type {string} */ each) => {
      const all = this.places[each] ?? this.ledger[each];
      if (!all) return null;
      const place = all[Math.min(ball, all.length - 1)];
      const values = takeColumn(samples, place, first, stride);
      if (!(this.now[TIME] > samples[first + (values.length - 1) * stride][TIME])) return values;
      return Float64Array.of(...values, this.now[place]);
    };
    if (name !== "total_energy") return own(name);
    const potential = /** @type {Float64Array} */ (own("potential_energy"));
    return own("kinetic_energy")?.map((value, i) => value + potential[i]) ?? null;
  }

  /**
   * Return one quantity at the newest instant; NaN if it has no place.
   * @param {string} name
   * @param {number} ball
   */
  newest(name, ball) {
    const all = this.places[name];
    return all ? this.now[all[Math.min(ball, all.length - 1)]] : NaN;
  }

  /**
   * Return what was played, from an instant on or as soon after it as a run can begin.
   * @param {import("../model/laws.js").System} system as it is now
   * @param {number} [since]
   */
  keep(system, since = this.end - SPAN) {
    const { samples } = this;
    const earliest = rowFrom(samples, since);
    // A stage of a drive lasts some time, so none begins with a change.
    const begins = (/** @type {number} */ i) => samples[i][BEGINS] > 0
      && !this.changes.some(({ time }) => time === samples[i][TIME]);
    let first = earliest;
    while (first < samples.length - 2 && !begins(first)) first += 1;
    return begins(first) ? new Kept(this, system, first, true) : new Kept(this, system, earliest, false);
  }
}

/** A stretch of what was played, which may be a run that can be computed again. */
export class Kept {
  /**
   * @param {Minute} minute
   * @param {import("../model/laws.js").System} system as it is at the end
   * @param {number} first sample
   * @param {boolean} begins whether a run can begin there
   */
  constructor(minute, system, first, begins) {
    this.minute = minute;
    this.first = first;
    const { samples, contacts, changes, cosines } = minute;
    const start = samples[first][TIME];
    this.start = start;
    this.firstContact = rowFrom(contacts, start);
    this.duration = minute.end - start;
    /** Whether the pivot was shaken. */
    this.isShaken = minute.shakenAt > start;
    /** Whether anything but the drive was changed. */
    this.byHand = minute.handAt >= start || (!begins && !this.isShaken);
    const cosine = /** @type {Cosine} */ (cosines.findLast((each) => each.start <= start) ?? cosines[0]);
    this.cosine = { ...cosine, start,
      phase: (cosine.phase + cosine.frequency * (start - cosine.start)) % (2 * Math.PI) };
    this.changes = changes.filter(({ time }) => time >= start);
    const row = (/** @type {string} */ name) => minute.places[name].map((place) => samples[first][place]);
    /** @type {Case} */
    this.case = { ...minute.case, system, angles: row("angle"), velocities: row("angular_velocity"), distances: [] };
  }

  /**
   * Return the drive, whose time begins with what was kept; the heights of a shaken pivot are columns.
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
      times: this.times, duration: this.duration };
  }

  /** The instants of its samples, from its beginning on. */
  get times() {
    return takeColumn(this.minute.samples, TIME, this.first).map((time) => time - this.start);
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
   * Return how far [rad] a run is from what was played.
   * @param {Run} again
   */
  deviation({ columns }) {
    const gaps = columns.angle.flatMap((angles, ball) => {
      const seen = takeColumn(this.minute.samples, this.minute.places.angle[ball], this.first);
      return Array.from(angles, (angle, i) => Math.abs(angle - seen[i]));
    });
    return gaps.reduce((most, gap) => Math.max(most, gap), 0);
  }

  /**
   * The samples by name: one column, or one for each ball.
   * @returns {Record<string, Float64Array[]>}
   */
  columns() {
    const { samples, places, ledger } = this.minute;
    const of = (/** @type {number[]} */ all) => all.map((place) => takeColumn(samples, place, this.first));
    /** @type {Record<string, Float64Array[]>} */
    const columns = {};
    for (const [name, all] of Object.entries(places)) {
      columns[name] = of(all);
      if (name === "potential_energy") columns.total_energy = columns.kinetic_energy.map((row, ball) =>
        row.map((value, i) => value + columns.potential_energy[ball][i]));
    }
    columns.time = [this.times];
    for (const [name, all] of Object.entries(ledger))
      columns[name] = of(all).map((sums) => sums.map((sum) => sum - sums[0]));
    if (columns.noise_work[0].every((work) => work === 0)) delete columns.noise_work;
    return columns;
  }

  /**
   * The contacts by name; kinds are numbers of the layout's.
   * @returns {Record<string, Float64Array[]>}
   */
  contactColumns() {
    const { angles, suspension } = this.case.system;
    const { layout, contacts } = this.minute;
    const of = (/** @type {number} */ place) => takeColumn(contacts, place, this.firstContact);
    const each = (/** @type {number} */ first) => Array.from({ length: angles }, (_, ball) => of(first + ball));
    const values = Array.from({ length: layout.contact_rows.count }, (_, row) => of(2 + row));
    return {
      contact_time: [of(TIME).map((time) => time - this.start)], contact_kind: [of(1)],
      angular_velocity_before: each(2), angular_velocity_after: each(2 + angles),
      ...(suspension === "string" ? onStrings(layout, values, angles) : {}),
    };
  }

  /**
   * What was played as a block, as runs are.
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
    const notes = [this.isShaken && t("keptShakenNote"), this.byHand && t("keptHandNote")];
    about.attributes.note = notes.filter(Boolean).join("; ") || t("keptNote");
    const note = this.isShaken ? "keptShaken" : this.byHand ? "keptHand"
      : this.isRun(again) ? "keptExact" : "keptChaos";
    return { ...block, about: { ...about, by_hand: this.byHand, python: "", command: "", note: t(note) } };
  }
}
