/** The motion of a toy that a hand holds, with what the stage and the curves ask of a run: it grows. */

import { ballsOf } from "../model/run_block.js";
import { fromBottom, poseOf, range, SHOWN_RADIUS } from "../player/motion.js";
import { Log } from "../player/events.js";

/** @typedef {import("../player/motion.js").MotionBall} MotionBall */
/** @typedef {import("./toy.js").Toy} Toy */

// How far back the curves reach [s], with some room.
const SPAN = 15.2;
// Every so manieth sample is in the curves: sixty a second.
const STRIDE = 4;
// Poses of the trail: every so manieth sample.
const TRAIL_STRIDE = 2;
// Room above the pivot that is always shown, in reaches of the balls.
const ABOVE = 0.3;
// How much of the way the picture's upper end goes in a frame.
const GROW = 0.25;
const SHRINK = 0.02;

export class GrowingMotion {
  /** @param {Toy} toy */
  constructor(toy) {
    this.toy = toy;
    this.balls = ballsOf(toy.system);
    /** What the balls did. */
    this.log = new Log(this.balls);
    toy.onContact = (time, kind, speeds) => {
      const { angles } = toy.system;
      const number = angles > 1 ? speeds[toy.kernels.layout.contact_rows.ball] : 0;
      this.log.meet(time, kind, speeds, speeds.slice(angles), number);
    };
    this.isString = toy.system.suspension === "string";
    /** The largest angle from the bottom since the start [rad]. */
    this.most = 0;
    this.follow();
    this.longest = Math.max(...this.balls.map((b) => b.length));
    this.contacts = new Float64Array(0);
    this.naturalFrequency = toy.system.naturalFrequency;
    this.grows = true;
    /** Nobody can go back in it, so that it pins no contact to an instant. */
    this.low = this.high = null;
    this.reach = toy.controls.drive_amplitude;
    this.top = 0;
  }

  /** Its last instant [s]. */
  get end() {
    return this.toy.time;
  }

  /** The instants of the last seconds. */
  get time() {
    return /** @type {Float64Array} */ (this.values("time"));
  }

  /** What the hand does, and what draws the balls down. */
  get about() {
    const { controls, system, isShaken } = this.toy;
    return { is_sinusoidal: !isShaken, attributes: { natural_frequency: system.naturalFrequency },
      options: { ...controls, drive: isShaken ? "measured_pivot" : "harmonic", gravity: system.gravity } };
  }

  /** Note what the balls did on their way to this instant. */
  follow() {
    const { angles, velocities, time } = this.toy;
    this.log.move(time, (row) => [angles[row], velocities[row]]);
    this.most = Math.max(this.most, ...angles.map(fromBottom));
  }

  /** The largest angle from the bottom since the start [rad]. */
  highest() {
    return this.most;
  }

  /** @param {MotionBall} ball */
  radius(ball) {
    return ball.radius || SHOWN_RADIUS * ball.length;
  }

  /**
   * Return the angle of a ball as it is drawn [rad].
   * @param {MotionBall} ball
   */
  angle(ball) {
    return ball.sign * this.toy.angles[ball.row];
  }

  /**
   * Return a quantity at the newest instant; NaN if it is not known.
   * @param {string} name
   * @param {number} [_time]
   * @param {number} [row]
   */
  at(name, _time, row = 0) {
    return this.toy.minute.newest(name, row);
  }

  /**
   * Return one quantity of the last seconds, of one ball where it has several rows.
   * @param {string} name
   * @param {number} [ball]
   */
  values(name, ball = 0) {
    return this.toy.minute.recent(name, ball, SPAN, STRIDE);
  }

  /** The pivot moves up and down. @returns {[number, number]} */
  get acrossRange() {
    return [0, 0];
  }

  /**
   * Return how far a ball is from the pivot [m].
   * @param {MotionBall} ball
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
   */
  rise() {
    const ends = this.balls.flatMap(({ row }) => range(this.values("angle", row) ?? []));
    const largest = Math.max(...ends.map(Math.abs));
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
   * Return the poses of the last moment, the oldest first, and now.
   * @param {number} _time now
   * @param {number} span how far back they go [s]
   */
  recent(_time, span) {
    const { balls, toy: { minute } } = this;
    const of = (/** @type {string} */ name, /** @type {number} */ row) => minute.recent(name, row, span, TRAIL_STRIDE);
    const heights = /** @type {Float64Array} */ (of("pivot_height", 0));
    const angles = balls.map(({ row }) => /** @type {Float64Array} */ (of("angle", row)));
    const distances = balls.map(({ row }) => of("distance", row));
    const place = (/** @type {MotionBall} */ ball) => balls.indexOf(ball);
    const poses = Array.from(heights, (height, i) => poseOf(height, balls,
      (ball) => ball.sign * angles[place(ball)][i], 0, (ball) => distances[place(ball)]?.[i] ?? ball.length));
    return [...poses, this.pose()];
  }
}
