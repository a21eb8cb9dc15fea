/** A run as the page knows it: the state at any instant, from the samples and the contacts. */

import { row } from "../page/block.js";
import { between, joined } from "./canvas.js";

/** @typedef {import("../page/block.js").Block} Block */
/** @typedef {{name: string, row: number, sign: number, length: number, radius: number,
 *   mass: number}} MotionBall */
/** @typedef {import("./canvas.js").Box} Box */
/** @typedef {ReturnType<typeof poseOf>} Pose */

// A ball of unknown or zero radius is drawn with this share of the length.
export const SHOWN_RADIUS = 0.04;
const BOX_SAMPLES = 4000;
// The box of a picture is made of those of stretches of so many natural periods.
const STRETCH = 4;
// Kinds of contact above this one are those of strings.
const RELEASE = 3;

/**
 * Return the first of so many places from which on something holds, their number if it holds at none.
 * @param {number} count
 * @param {(place: number) => boolean} holds
 */
export function firstWhere(count, holds) {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (holds(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/**
 * Return the last index whose value does not exceed `x`, 0 if there is none.
 * @param {ArrayLike<number>} values increasing
 * @param {number} x
 */
export const before = (values, x) => Math.max(firstWhere(values.length, (i) => values[i] > x) - 1, 0);

/**
 * Return the least and the largest finite value of all, or from one place up to another.
 * @param {ArrayLike<number>} values others than finite numbers count for nothing
 * @param {number} [from]
 * @param {number} [to]
 * @returns {[number, number]}
 */
export function range(values, from = 0, to = values.length) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = from; i < to; i += 1) {
    const value = values[i];
    if (!Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 0];
}

/**
 * Return an angle within (-180°, 180°].
 * @param {number} angle [°]
 */
export function wrap(angle) {
  return angle - 360 * Math.ceil((angle - 180) / 360);
}

/**
 * Return how far an angle is from the bottom, either way and without whole turns [rad].
 * @param {number} angle [rad]
 */
export const fromBottom = (angle) => Math.abs(angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI)));

/**
 * Return pivot and balls where the balls have these angles: positions in m, x to the right and y up.
 * @param {number} height of the pivot [m]
 * @param {MotionBall[]} balls
 * @param {(ball: MotionBall) => number} angleOf a ball as it is drawn [rad]
 * @param {number} [across] how far the pivot is to the right [m]
 * @param {(ball: MotionBall) => number} [distanceOf] a ball from the pivot [m]
 */
export function poseOf(height, balls, angleOf, across = 0, distanceOf = ({ length }) => length) {
  return {
    across, height,
    balls: balls.map((ball) => {
      const angle = angleOf(ball);
      const distance = distanceOf(ball);
      return { ball, angle, distance, x: across + distance * Math.sin(angle),
        y: height - distance * Math.cos(angle) };
    }),
  };
}

/**
 * Return the instants of a run up to the last one with values: a run that stopped early has none later.
 * @param {Block} block
 */
function knownInstants(block) {
  const time = /** @type {Float64Array} */ (block.arrays.time);
  const angles = row(block, "angle", 0);
  let count = time.length;
  while (count > 2 && Number.isNaN(angles[count - 1])) count -= 1;
  return time.subarray(0, count);
}

export class Motion {
  /** @param {Block} block */
  constructor(block) {
    this.block = block;
    this.about = block.about;
    this.time = knownInstants(block);
    this.end = this.time[this.time.length - 1];
    /** @type {MotionBall[]} */
    this.balls = block.about.balls;
    this.contacts = block.arrays.contact_time ?? new Float64Array(0);
    this.low = block.about.attributes?.contact_angle_low ?? null;
    this.high = block.about.attributes?.contact_angle_high ?? null;
    this.longest = Math.max(...this.balls.map((b) => b.length));
    /** [rad/s] */
    this.naturalFrequency = block.about.attributes?.natural_frequency ?? NaN;
    /** @type {Box[]} of the stretches of the run that were asked for */
    this.boxes = [];
    /** Whether balls hang on strings. */
    this.isString = "distance" in block.arrays;
    /** Whether it goes on while it is shown. */
    this.grows = false;
    /** What it notes of its events as it grows. @type {import("./events.js").Log | null} */
    this.log = null;
    /** @type {Record<string, [number, number]>} */
    this.ranges = {};
    /** The largest angle up to each sample [rad], as far as it was asked for. @type {number[]} */
    this.peaks = [];
  }

  /** The least and the largest height of the pivot [m]. */
  get pivotRange() {
    return this.ranges.height ??= range(this.values("pivot_height") ?? [0]);
  }

  /** How far the pivot goes to the left and to the right [m]. */
  get acrossRange() {
    return this.ranges.across ??= range(this.values("pivot_across") ?? [0]);
  }

  /**
   * Return one quantity over time, of one ball where it has several rows.
   * @param {string} name
   * @param {number} [ball]
   */
  values(name, ball = 0) {
    if (!(name in this.block.arrays)) return null;
    const all = row(this.block, name, Math.min(ball, this.block.shapes[name][0] - 1));
    return all.length === this.block.arrays.time.length ? all.subarray(0, this.time.length) : all;
  }

  /**
   * Return the largest angle from the bottom of any ball up to an instant [rad].
   * @param {number} time
   */
  highest(time) {
    const { peaks } = this;
    const last = before(this.time, time);
    const angles = this.balls.map((ball) => /** @type {Float32Array} */ (this.values("angle", ball.row)));
    for (let i = peaks.length; i <= last; i += 1) {
      let most = peaks[i - 1] ?? 0;
      for (const each of angles) most = Math.max(most, fromBottom(each[i]));
      peaks.push(most);
    }
    return peaks[last];
  }

  /**
   * Return the drawn radius of a ball [m].
   * @param {MotionBall} ball
   */
  radius(ball) {
    return ball.radius || SHOWN_RADIUS * ball.length;
  }

  /**
   * Return a quantity at an instant, linear between samples.
   * @param {string} name
   * @param {number} time
   * @param {number} [ball]
   */
  at(name, time, ball = 0) {
    const values = this.values(name, ball);
    if (!values) return NaN;
    const i = Math.min(before(this.time, time), this.time.length - 2);
    const share = (time - this.time[i]) / (this.time[i + 1] - this.time[i]);
    return values[i] + Math.min(Math.max(share, 0), 1) * (values[i + 1] - values[i]);
  }

  /**
   * Return the angle of a ball at an instant [rad]: cubic between samples, and up to and from the
   * wall where a contact lies between them.
   * @param {MotionBall} ball
   * @param {number} time
   */
  angle(ball, time) {
    const angles = /** @type {Float32Array} */ (this.values("angle", ball.row));
    const rates = /** @type {Float32Array} */ (this.values("angular_velocity", ball.row));
    const i = Math.min(before(this.time, time), this.time.length - 2);
    if (this.isLoose(ball, i)) {
      const [x, y] = this.loose(ball, i, time);
      const turns = Math.round((angles[i] - Math.atan2(x, -y)) / (2 * Math.PI));
      return ball.sign * (Math.atan2(x, -y) + 2 * Math.PI * turns);
    }
    let t0 = this.time[i];
    let t1 = this.time[i + 1];
    let x0 = angles[i];
    let x1 = angles[i + 1];
    let v0 = rates[i];
    let v1 = rates[i + 1];
    if (this.low !== null && this.contacts.length) {
      const after = this.block.arrays.angular_velocity_after;
      const ahead = this.block.arrays.angular_velocity_before;
      const kinds = this.block.arrays.contact_kind;
      for (let k = before(this.contacts, t0); k < this.contacts.length; k += 1) {
        const at = this.contacts[k];
        if (at < t0) continue;
        if (at > t1) break;
        const wall = this.wall(kinds[k], 0.5 * (x0 + x1));
        if (at <= time) [t0, x0, v0] = [at, wall, after[k]];
        else {
          [t1, x1, v1] = [at, wall, ahead[k]];
          break;
        }
      }
    }
    const h = t1 - t0;
    if (!(h > 0)) return ball.sign * x0;
    const s = (time - t0) / h;
    const angle =
      x0 * (1 + 2 * s) * (1 - s) ** 2 + x1 * s * s * (3 - 2 * s) +
      h * s * (1 - s) * (v0 * (1 - s) - v1 * s);
    return ball.sign * angle;
  }

  /**
   * Return how far a ball is from the pivot at an instant [m].
   * @param {MotionBall} ball
   * @param {number} time
   */
  distance(ball, time) {
    const i = Math.min(before(this.time, time), this.time.length - 2);
    return this.isLoose(ball, i) ? Math.min(Math.hypot(...this.loose(ball, i, time)), ball.length) : ball.length;
  }

  /**
   * Return the numbers of the contacts from one sample to the next.
   * @param {number} i
   */
  between(i) {
    const [begin, end] = [this.time[i], this.time[i + 1]];
    const numbers = [];
    for (let k = before(this.contacts, begin); this.contacts[k] <= end; k += 1)
      if (this.contacts[k] >= begin) numbers.push(k);
    return numbers;
  }

  /**
   * Return whether a ball leaves its circle between a sample and the next.
   * @param {MotionBall} ball
   * @param {number} i
   */
  isLoose({ row: which }, i) {
    const slack = this.values("slack", which);
    if (!slack) return false;
    const kinds = this.block.arrays.contact_kind;
    return slack[i] > 0 || slack[i + 1] > 0 || this.between(i).some((k) => kinds[k] > RELEASE);
  }

  /**
   * The position of a ball on a slack string from the pivot [m], to the right and up: cubic between
   * samples, and straight on from them up to contacts between them.
   * @param {MotionBall} ball
   * @param {number} i of the sample before
   * @param {number} time
   */
  loose({ row: which }, i, time) {
    const [angle, rate, distance, radial] = ["angle", "angular_velocity", "distance", "radial_velocity"]
      .map((name) => /** @type {Float64Array} */ (this.values(name, which)));
    const [one, other] = [i, i + 1].map((k) => {
      const [s, c, speed] = [Math.sin(angle[k]), Math.cos(angle[k]), distance[k] * rate[k]];
      return { t: this.time[k], x: [distance[k] * s, -distance[k] * c],
        v: [radial[k] * s + speed * c, speed * s - radial[k] * c] };
    });
    const on = (/** @type {typeof one} */ { t, x, v }, /** @type {number} */ at) =>
      x.map((value, j) => value + v[j] * (at - t));
    const inside = this.between(i).map((k) => this.contacts[k]);
    if (inside.length) {
      const [first, last] = [inside[0], inside[inside.length - 1]];
      if (time <= first) return on(one, time);
      if (time >= last) return on(other, time);
      const [from, to] = [on(one, first), on(other, last)];
      return from.map((value, j) => value + ((time - first) / (last - first)) * (to[j] - value));
    }
    const h = other.t - one.t;
    const s = (time - one.t) / h;
    return one.x.map((value, j) => value * (1 + 2 * s) * (1 - s) ** 2 + other.x[j] * s * s * (3 - 2 * s)
      + h * s * (1 - s) * (one.v[j] * (1 - s) - other.v[j] * s));
  }

  /**
   * Return the angle of the wall at which a contact of this kind happens [rad].
   * @param {number} kind index in "bottom, top, rest, release"
   * @param {number} near
   */
  wall(kind, near) {
    if (kind === 0) return this.low;
    if (kind === 1) return this.high;
    return Math.abs(near - this.low) < Math.abs(near - this.high) ? this.low : this.high;
  }

  /**
   * Return pivot and balls at an instant: positions in m, x to the right and y up.
   * @param {number} time
   */
  pose(time) {
    return poseOf(this.at("pivot_height", time), this.balls, (ball) => this.angle(ball, time),
      this.at("pivot_across", time) || 0, (ball) => this.distance(ball, time));
  }

  /**
   * Return the poses of the last moment, the oldest first: at multiples of a step, so that the
   * picture of a quick motion stands still, and now.
   * @param {number} time now
   * @param {number} span how far back they go [s]
   * @param {number} count of the steps in it
   */
  recent(time, span, count) {
    const step = span / count;
    const first = Math.max(0, time - span);
    const poses = [this.pose(first)];
    for (let k = Math.floor(first / step) + 1; k * step < time; k += 1) poses.push(this.pose(k * step));
    poses.push(this.pose(time));
    return poses;
  }

  /**
   * Return a box that holds the balls, their trails and the pivot at an instant, and has room for the
   * motion around it. It changes steadily: at the border of two stretches it holds both, and in
   * between it is a mean of those at the borders, both of which hold the stretch.
   * @param {number} time
   * @returns {Box}
   */
  box(time) {
    const count = Math.max(1, Math.floor((this.end * this.naturalFrequency) / (2 * Math.PI * STRETCH)) || 1);
    const place = Math.min(Math.max((time / this.end) * count, 0), count);
    const k = Math.min(Math.floor(place), count - 1);
    const [past, now, next] = [k - 1, k, k + 1].map((each) => {
      const stretch = Math.min(Math.max(each, 0), count - 1);
      this.boxes[stretch] ??= this.measure(stretch / count, (stretch + 1) / count);
      return this.boxes[stretch];
    });
    return between(joined([past, now]), joined([now, next]), place - k);
  }

  /**
   * Return the box of a part of the run, of long parts as some thousand instants see it.
   * @param {number} from in shares of the run
   * @param {number} to
   * @returns {Box}
   */
  measure(from, to) {
    const trail = 2 * Math.PI / this.naturalFrequency || 0;
    const first = before(this.time, from * this.end - trail);
    const last = Math.min(before(this.time, to * this.end) + 1, this.time.length - 1);
    const stride = Math.max(1, Math.floor((last - first) / BOX_SAMPLES));
    const pivot = /** @type {Float32Array} */ (this.values("pivot_height"));
    const aside = this.values("pivot_across");
    let [left, right] = this.acrossRange;
    let [low, high] = this.pivotRange;
    for (const ball of this.balls) {
      const angles = /** @type {Float32Array} */ (this.values("angle", ball.row));
      const distances = this.values("distance", ball.row);
      const r = this.radius(ball);
      for (let i = first; i <= last; i += stride) {
        if (!Number.isFinite(angles[i])) continue;
        const distance = distances?.[i] ?? ball.length;
        const x = (aside?.[i] ?? 0) + ball.sign * distance * Math.sin(angles[i]);
        const y = pivot[i] - distance * Math.cos(angles[i]);
        left = Math.min(left, x - r);
        right = Math.max(right, x + r);
        low = Math.min(low, y - r);
        high = Math.max(high, y + r);
      }
    }
    return { left, right, low, high };
  }

  /**
   * Return how fast the balls meet at a contact [rad/s]: a mirrored ball meets its twin.
   * @param {number} k number of the contact
   */
  closingSpeed(k) {
    const rates = this.balls.map(({ row, sign }) =>
      sign * /** @type {ArrayLike<number>} */ (this.values("angular_velocity_before", row))[k]);
    return Math.abs(rates[0] - (rates[1] ?? 0));
  }

  /** Return the instants at which the drive begins a period; none for a drive without one. */
  strobes() {
    return [...(this.block.arrays.strobe ?? [])].filter((instant) => instant <= this.end);
  }
}
