/** A motion that is still happening, with what the scene asks of a run, and its last seconds. */

import { ballsOf } from "../model/block.js";
import { isFelt, poseOf, SHOWN_RADIUS } from "../shared/motion.js";
import { Log } from "../shared/swings.js";
import { DEGREE } from "../shared/units.js";

/** @typedef {import("../shared/motion.js").Ball} Ball */
/** @typedef {import("./toy.js").Toy} Toy */

/** How far back the curves reach [s]. */
export const SPAN = 15;
// Instants that are closer to the one before are left out.
const SPACING = 1 / 64; // s
// Room above the pivot that is always shown, in reaches of the balls.
const ABOVE = 0.3;
// How much of the way the picture's upper end goes in a frame.
const GROW = 0.25;
const SHRINK = 0.02;
const ROOM = Math.ceil(SPAN / SPACING) + 2;

/** The last seconds of some quantities, in the order of time. */
export class History {
  /** @param {string[]} names */
  constructor(names) {
    this.count = 0;
    this.next = 0;
    this.time = new Float64Array(ROOM);
    /** @type {Record<string, Float64Array>} */
    this.values = Object.fromEntries(names.map((name) => [name, new Float64Array(ROOM)]));
  }

  /**
   * @param {number} time
   * @param {Record<string, number>} values
   */
  add(time, values) {
    const since = time - this.time[(this.next + ROOM - 1) % ROOM];
    if (since < 0) this.count = 0;
    if (this.count && since < SPACING) return;
    this.time[this.next] = time;
    for (const name of Object.keys(this.values)) this.values[name][this.next] = values[name];
    this.next = (this.next + 1) % ROOM;
    this.count = Math.min(this.count + 1, ROOM);
  }

  /**
   * Return the place of the k-th of the samples that are kept, the oldest being the first.
   * @param {number} k
   */
  at(k) {
    return (this.next + ROOM - this.count + k) % ROOM;
  }

  /**
   * Return the least and the largest value that is kept.
   * @param {string[]} names
   * @param {number} [since] of the last so many seconds only
   * @returns {[number, number]}
   */
  range(names, since = Infinity) {
    let [low, high] = [Infinity, -Infinity];
    const newest = this.time[this.at(this.count - 1)];
    for (const name of names)
      for (let k = this.count - 1; k >= 0; k -= 1) {
        const i = this.at(k);
        if (newest - this.time[i] > since) break;
        const value = this.values[name][i];
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    return low <= high ? [low, high] : [0, 0];
  }
}

/** What `Scene` draws of a toy. */
export class LiveMotion {
  /**
   * @param {Toy} toy
   * @param {History} history of its last seconds: angles in degrees, and the pivot
   */
  constructor(toy, history) {
    this.toy = toy;
    this.history = history;
    this.balls = ballsOf(toy.system);
    /** What the balls did. */
    this.log = new Log(this.balls);
    /** Balls whose strings went slack or taut since the last picture. @type {Ball[]} */
    this.pulled = [];
    toy.onContact = (time, kind, speeds) => {
      const { angles } = toy.system;
      const { contact_rows: { ball, radial } } = toy.kernels.layout;
      const number = angles > 1 ? speeds[ball] : 0;
      this.log.meet(time, kind, speeds, speeds.slice(angles), number);
      this.pulled.push(...(number ? [this.balls[number - 1]] : this.balls).filter(({ row, length }) =>
        isFelt(kind, speeds[radial + row], toy.system.naturalFrequency * length)));
    };
    this.isString = toy.system.suspension === "string";
    this.follow();
    this.longest = Math.max(...this.balls.map((b) => b.length));
    this.contacts = new Float64Array(0);
    this.naturalFrequency = toy.system.naturalFrequency;
    this.end = Infinity;
    this.reach = toy.controls.drive_amplitude;
    this.top = 0;
  }

  /** What the hand does, and what draws the balls down. */
  get about() {
    const { controls, system, isShaken } = this.toy;
    return { is_sinusoidal: !isShaken,
      options: { ...controls, drive: isShaken ? "measured_pivot" : "harmonic", gravity: system.gravity } };
  }

  /** Note what the balls did on their way to this instant. */
  follow() {
    const { angles, velocities, time } = this.toy;
    this.log.move(time, (row) => [angles[row], velocities[row]]);
  }

  /** @param {Ball} ball */
  radius(ball) {
    return ball.radius || SHOWN_RADIUS * ball.length;
  }

  /**
   * Return the angle of a ball as it is drawn [rad].
   * @param {Ball} ball
   */
  angle(ball) {
    return ball.sign * this.toy.angles[ball.row];
  }

  /**
   * Return a quantity near the newest instant.
   * @param {string} name
   * @param {number} time
   * @param {number} [row]
   */
  at(name, time, row = 0) {
    const { toy } = this;
    if (name === "pivot_velocity") return toy.pivot.velocity;
    return name === "angular_velocity" ? toy.velocities[row] : NaN;
  }

  /** Nothing is known of the whole motion. */
  values() {
    return null;
  }

  /** The pivot moves up and down. @returns {[number, number]} */
  get acrossRange() {
    return [0, 0];
  }

  /**
   * Return how far a ball is from the pivot [m].
   * @param {Ball} ball
   */
  distance(ball) {
    return this.toy.distances[ball.row];
  }

  /** The heights that the pivot reaches. @returns {[number, number]} */
  get pivotRange() {
    return [-this.reach, this.reach];
  }

  /** Return the box that holds the balls: below the pivot, and above as far as they go [m]. */
  box() {
    const side = Math.max(...this.balls.map((b) => b.length + this.radius(b)));
    const least = Math.max(ABOVE * side, 1.6 * this.reach);
    return { left: -side, right: side, low: -side - this.reach,
      high: Math.max(least, Math.min(this.top, side + this.reach)) };
  }

  /**
   * Let the box follow how high the balls went lately, and a shaken pivot.
   * @param {number} largest angle of the last seconds [rad]
   */
  rise(largest) {
    const side = this.longest + Math.max(...this.balls.map((b) => this.radius(b)));
    const above = Math.min(Math.max(largest - Math.PI / 2, 0), Math.PI / 2);
    const needed = side * Math.sin(above) + this.reach;
    this.top += (needed > this.top ? GROW : SHRINK) * (needed - this.top);
    const beyond = this.toy.isShaken ? Math.abs(this.toy.pivot.height) - this.reach : 0;
    if (beyond > 0) this.reach += GROW * beyond;
  }

  /** Return pivot and balls now: positions in m, x to the right and y up. */
  pose() {
    return poseOf(this.toy.pivot.height, this.balls, (ball) => this.angle(ball), 0, (ball) => this.distance(ball));
  }

  /**
   * Return the poses of the last moment as the history has them, the oldest first, and one between
   * each two: a ball that moves fast turns far in a picture.
   * @param {number} time now
   * @param {number} span how far back they go [s]
   */
  recent(time, span) {
    const { history, balls } = this;
    const { pivot, right, left, far, other } = history.values;
    /** @type {number[][]} */
    const rows = [];
    for (let k = history.count - 1; k >= 0; k -= 1) {
      const i = history.at(k);
      if (history.time[i] < time - span) break;
      const next = rows.at(-1);
      const row = [pivot[i], right[i], left[i], far[i], other[i]];
      if (next) rows.push(row.map((value, j) => 0.5 * (value + next[j])));
      rows.push(row);
    }
    const poses = rows.reverse().map(([height, ...values]) => poseOf(height, balls,
      ({ name }) => values[name === "left" ? 1 : 0] * DEGREE, 0, ({ name }) => values[name === "left" ? 3 : 2]));
    return [...poses, this.pose()];
  }
}
