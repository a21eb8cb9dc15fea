/** What balls do, as events in time: turning points, full turns, clacks, rest and lift-off. */

import { firstWhere, wrap } from "./motion.js";
import { DEGREE } from "../page/unit_text.js";

/** @typedef {import("./motion.js").Motion} Motion */
/**
 * A peak is a turning point at which the ball falls back, a dip one at which it rises again; it is
 * low where it passes its lowest place, after a turn if that made a full circle. `ball` is the one that does it, "both" for mirrored balls and for contacts; `angle`
 * is that from hanging, in (-180, 180] degrees; `speed` how fast balls meet [rad/s].
 * @typedef {{time: number, kind: "peak" | "dip" | "low" | "turn" | typeof KINDS[number],
 *   ball: string, angle: number, speed: number}} Event
 */

const FULL = 2 * Math.PI;
/** Contacts of a run, by their number. */
export const KINDS = /** @type {const} */ (["bottom", "top", "rest", "release", "slack", "taut"]);
const SIDES = ["both", "right", "left"];
// A log of a motion without end forgets the oldest half of so many.
const MOST = 20_000;

/**
 * Return an angle from hanging, in (-180, 180] degrees.
 * @param {number} angle [rad]
 */
export function wrapped(angle) {
  return wrap(angle / DEGREE);
}

/** @param {Event} event */
export const isClack = ({ kind }) => kind === "bottom" || kind === "top";

/** One ball on its way from state to state: it notes where it turns. */
class Follower {
  /**
   * @param {{name: string, sign: number}} ball
   * @param {(kind: "peak" | "dip" | "low" | "turn", time: number, angle: number) => void} note
   */
  constructor({ sign }, note) {
    this.sign = sign;
    this.note = note;
    this.time = NaN;
    this.angle = 0;
    this.velocity = 0;
    /** The way in which it moved last; 0 at rest. */
    this.way = 0;
    /** Where it passed its lowest place last, in full turns. */
    this.lowest = 0;
  }

  /**
   * Begin at a state, or go on from it after a jump of the velocity.
   * @param {number} time
   * @param {number} angle [rad]
   * @param {number} velocity [rad/s]
   */
  begin(time, angle, velocity) {
    if (Number.isNaN(this.time)) this.lowest = Math.round(angle / FULL);
    [this.time, this.angle, this.velocity] = [time, angle, velocity];
    this.way = Math.sign(velocity);
  }

  /**
   * Go on to a state; the motion in between is smooth.
   * @param {number} time
   * @param {number} angle [rad]
   * @param {number} velocity [rad/s]
   */
  move(time, angle, velocity) {
    const { time: t0, angle: x0, velocity: v0, way } = this;
    const turns = way * velocity < 0;
    [this.time, this.angle, this.velocity] = [time, angle, velocity];
    if (velocity !== 0) this.way = Math.sign(velocity);
    if (turns) {
      const share = v0 / (v0 - velocity);
      const h = time - t0;
      // The cubic through both states.
      const at = x0 + share * share * (3 - 2 * share) * (angle - x0) +
        h * share * (1 - share) * (v0 * (1 - share) - velocity * share);
      this.note(way * wrapped(at) > 0 ? "peak" : "dip", t0 + share * h, wrapped(this.sign * at));
    }
    const lowest = Math.max(Math.floor(x0 / FULL), Math.floor(angle / FULL));
    if (lowest === Math.min(Math.floor(x0 / FULL), Math.floor(angle / FULL))) return;
    this.note(lowest === this.lowest ? "low" : "turn", time, 0);
    this.lowest = lowest;
  }

  /**
   * Pass a contact, with the velocities around it [rad/s]; returns the angle there [rad].
   * @param {number} time
   * @param {number} before
   * @param {number} after
   */
  meet(time, before, after) {
    // Where it is follows from how fast it got there.
    const angle = this.angle + 0.5 * (time - this.time) * (this.velocity + before);
    this.move(time, angle, before);
    this.begin(time, angle, after);
    return angle;
  }
}

/** The events of a motion, in the order of time. */
export class Log {
  /** @param {{name: string, row: number, sign: number}[]} balls on show */
  constructor(balls) {
    this.isPair = balls.length > 1;
    /** @type {Event[]} */
    this.events = [];
    const rows = balls.filter((ball, i) => balls.findIndex((b) => b.row === ball.row) === i);
    const isMirrored = rows.length < balls.length;
    this.followers = rows.map((ball) => new Follower(ball, (kind, time, angle) => {
      this.add({ time, kind, ball: isMirrored ? "both" : ball.name, angle, speed: 0 });
    }));
  }

  /** @param {Event} event whose time may lie a little before that of the last one */
  add(event) {
    this.events.splice(this.after(event.time), 0, event);
    if (this.events.length > MOST) this.events.splice(0, MOST / 2);
  }

  /**
   * Go on to the state of each row; balls that do not move at all rest on each other.
   * @param {number} time
   * @param {(row: number) => [number, number]} state angle [rad] and velocity [rad/s]
   */
  move(time, state) {
    if (this.isPair && !this.events.length && this.followers.every(({ velocity, angle }, row) =>
      velocity === 0 && state(row)[1] === 0 && state(row)[0] === angle))
      this.add({ time: this.followers[0].time, kind: "rest", ball: "both",
        angle: wrapped(this.followers[0].angle), speed: 0 });
    this.followers.forEach((follower, row) => {
      const [angle, velocity] = state(row);
      if (!Number.isFinite(angle)) return;
      if (Number.isNaN(follower.time)) follower.begin(time, angle, velocity);
      else follower.move(time, angle, velocity);
    });
  }

  /**
   * Pass a contact, with the velocity of each row around it.
   * @param {number} time
   * @param {number} kind its number
   * @param {ArrayLike<number>} before [rad/s]
   * @param {ArrayLike<number>} after [rad/s]
   * @param {number} [number] of the ball whose string it is, 0 for both
   */
  meet(time, kind, before, after, number = 0) {
    const angles = this.followers.map((follower, row) => follower.meet(time, before[row], after[row]));
    const speed = Math.abs(this.followers.length > 1 ? before[0] - before[1] : 2 * before[0]);
    this.add({ time, kind: KINDS[kind], ball: SIDES[number], angle: wrapped(angles[Math.max(number - 1, 0)]),
      speed });
  }

  /**
   * Return the events after an instant, up to another one.
   * @param {number} from
   * @param {number} to
   */
  between(from, to) {
    return this.events.slice(this.after(from), this.after(to));
  }

  /**
   * Return the index of the first event after an instant.
   * @param {number} time
   */
  after(time) {
    return firstWhere(this.events.length, (i) => this.events[i].time > time);
  }
}

/**
 * Return the events of a run.
 * @param {Motion} motion
 */
export function logOf(motion) {
  const { time, contacts } = motion;
  const log = new Log(motion.balls);
  const rows = log.followers.map((_, row) => ({
    angle: motion.values("angle", row) ?? [], velocity: motion.values("angular_velocity", row) ?? [],
    before: motion.values("angular_velocity_before", row) ?? [],
    after: motion.values("angular_velocity_after", row) ?? [],
  }));
  const kinds = motion.block.arrays.contact_kind;
  const whose = motion.values("contact_ball");
  let k = 0;
  for (let i = 0; i < time.length; i += 1) {
    for (; k < contacts.length && i > 0 && contacts[k] <= time[i]; k += 1)
      log.meet(contacts[k], kinds[k], rows.map(({ before }) => before[k]),
        rows.map(({ after }) => after[k]), whose?.[k]);
    log.move(time[i], (row) => [rows[row].angle[i], rows[row].velocity[i]]);
  }
  return log;
}
