/** A motion that is still happening, with what the scene asks of a run, and its last seconds. */

import { SHOWN_RADIUS } from "../shared/motion.js";

/** @typedef {import("../shared/motion.js").Ball} Ball */
/** @typedef {import("./link.js").Frame} Frame */

/** How far back the curves reach [s]. */
export const SPAN = 15;
const PER_SECOND = 60;
// Room above the pivot that is always shown, in reaches of the balls.
const ABOVE = 0.3;
// How much of the way the picture's upper end goes in a frame.
const GROW = 0.25;
const SHRINK = 0.02;
const ROOM = SPAN * PER_SECOND + 2;

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
    if (this.count && time < this.time[(this.next + ROOM - 1) % ROOM]) this.count = 0;
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
   * @returns {[number, number]}
   */
  range(names) {
    let [low, high] = [Infinity, -Infinity];
    for (const name of names)
      for (let k = 0; k < this.count; k += 1) {
        const value = this.values[name][this.at(k)];
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    return low <= high ? [low, high] : [0, 0];
  }
}

/** What `Scene` draws, from the newest frame. */
export class LiveMotion {
  /** @param {any} about what the server said when the toy was ready */
  constructor(about) {
    this.about = { options: { drive: "harmonic", gravity: about.gravity } };
    /** @type {Ball[]} */
    this.balls = about.balls;
    this.angles = about.angles;
    this.longest = Math.max(...this.balls.map((b) => b.length));
    this.contacts = new Float64Array(0);
    this.end = Infinity;
    /** @type {Frame} */
    this.frame = { time: 0, angle_1: 0, angle_2: 0, velocity_1: 0, velocity_2: 0,
      pivot_height: 0, pivot_velocity: 0, drive_amplitude: about.controls.drive_amplitude };
    this.reach = about.controls.drive_amplitude;
    this.top = 0;
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
    return ball.sign * (ball.row === 0 ? this.frame.angle_1 : this.frame.angle_2);
  }

  /**
   * Return a quantity near the newest instant.
   * @param {string} name
   * @param {number} time
   * @param {number} [row]
   */
  at(name, time, row = 0) {
    const { frame } = this;
    if (name === "pivot_height")
      return frame.pivot_height + frame.pivot_velocity * (time - frame.time);
    if (name === "angular_velocity") return row === 0 ? frame.velocity_1 : frame.velocity_2;
    return frame[name] ?? NaN;
  }

  /** Return the heights that the pivot reaches, as far as is known. */
  values() {
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
   * Follow how high the balls went lately; returns whether the box has to change.
   * @param {number} largest angle of the last seconds [rad]
   */
  rise(largest) {
    const side = this.longest + Math.max(...this.balls.map((b) => this.radius(b)));
    const above = Math.min(Math.max(largest - Math.PI / 2, 0), Math.PI / 2);
    const wanted = side * Math.sin(above) + this.reach;
    const before = this.top;
    this.top += (wanted > before ? GROW : SHRINK) * (wanted - before);
    return Math.abs(this.top - before) > 1e-5 * side;
  }

  /** Return pivot and balls now: positions in m, x to the right and y up. */
  pose() {
    const height = this.frame.pivot_height;
    return {
      height,
      balls: this.balls.map((ball) => {
        const angle = this.angle(ball);
        return {
          ball, angle, x: ball.length * Math.sin(angle), y: height - ball.length * Math.cos(angle),
        };
      }),
    };
  }
}
