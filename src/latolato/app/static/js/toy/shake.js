/** What shakes the pivot of a toy: the motion sensor of a phone, or a pointer that drags it. */

import { t } from "../strings.js";

/** @typedef {import("./drive.js").Lead} Lead */
/** @typedef {import("./toy.js").Toy} Toy */
/** @typedef {{time: number, value: number}} Sample */

// Motions slower than this are left out, since nobody shakes so slowly while the errors of a sensor,
// integrated twice, do drift so: 0.3 Hz. The time constant is 1/SLOW, half a second.
const SLOW = 2 * Math.PI * 0.3; // rad/s
// Together with the slow mean of gravity this makes a Butterworth filter of order three.
const DAMPING_RATIO = 0.5;
// A pointer is followed this fast, without swinging.
const FOLLOW = 40; // rad/s
// Samples come 60 times a second, in time for the instants between them to be read so much later.
const DELAY = 25; // ms
// A sensor is silent after so long; what it reported last fades before.
const LOST = 300; // ms
const FADING = [50, 150]; // ms
// How long a page says that shaking was cut off.
const SHOWN = 3000; // ms
// A sensor that is there reports itself within this time.
const PATIENCE = 1000; // ms

/** The last samples of a quantity, read a little later so that most instants lie between two. */
export class Feed {
  constructor() {
    /** @type {Sample[]} */
    this.samples = [];
  }

  /**
   * @param {number} time in ms
   * @param {number} value
   */
  add(time, value) {
    const { samples } = this;
    if (samples.length && time <= samples[samples.length - 1].time) return;
    samples.push({ time, value });
    if (samples.length > 8) samples.shift();
  }

  /**
   * Return the value at an instant, linear between samples and constant beyond them, and how old the
   * newest sample is then [ms].
   * @param {number} wall
   */
  at(wall) {
    const time = wall - DELAY;
    const next = this.samples.findIndex((sample) => sample.time > time);
    const [before, after] = [this.samples.at(next < 0 ? -1 : Math.max(next - 1, 0)),
      this.samples.at(next)];
    if (!before || !after) return { value: 0, age: Infinity };
    const span = after.time - before.time;
    const share = span > 0 ? Math.max(time - before.time, 0) / span : 0;
    return { value: before.value + share * (after.value - before.value),
      age: wall - this.samples[this.samples.length - 1].time };
  }
}

/**
 * The acceleration of a phone along the vertical, however it is held.
 *
 * Sensors report the acceleration less that of gravity, which is 9.8 m/s^2 upwards at rest; iOS
 * reports the opposite. In both, the slow mean lies along the vertical, and what is added along the
 * mean is the phone's acceleration upwards.
 * @implements {Lead}
 */
export class Sensor {
  constructor() {
    this.rate = SLOW;
    this.dampingRatio = DAMPING_RATIO;
    this.feed = new Feed();
    /** @type {number[]} */
    this.mean = [0, 0, 0];
    this.time = -Infinity;
    this.count = 0;
  }

  /**
   * @param {number} time of the page's clock [ms]
   * @param {number[]} reported along the axes of the phone [m/s^2]
   */
  add(time, reported) {
    const gap = time - this.time;
    this.time = time;
    this.count = gap > LOST ? 1 : this.count + 1;
    // At first the mean of all samples.
    const share = Math.max(1 / this.count, 1 - Math.exp((-SLOW * gap) / 1000));
    this.mean = this.mean.map((before, i) => before + share * (reported[i] - before));
    const gravity = Math.hypot(...this.mean);
    const along = reported.reduce((sum, value, i) => sum + value * this.mean[i], 0) / gravity;
    this.feed.add(time, gravity > 0 ? along - gravity : 0);
  }

  /**
   * A sensor that falls silent fades, and the pivot comes to rest.
   * @param {number} wall
   */
  at(wall) {
    const { value, age } = this.feed.at(wall);
    const [fresh, faded] = FADING;
    const share = Math.min(Math.max((faded - age) / (faded - fresh), 0), 1);
    return { acceleration: share * value, height: 0 };
  }
}

/** A pointer that drags the pivot. @implements {Lead} */
export class Pointer {
  constructor() {
    this.rate = FOLLOW;
    this.dampingRatio = 1;
    this.feed = new Feed();
  }

  /** @param {number} wall */
  at(wall) {
    return { acceleration: 0, height: this.feed.at(wall).value };
  }
}

/**
 * Return why this page has no sensor, as the name of a text; null where it may listen. Browsers
 * that ask their user do so only in answer to a click.
 * @returns {Promise<"shakeInsecure" | "shakeNone" | "shakeRefused" | null>}
 */
async function whyNot() {
  if (!window.isSecureContext) return "shakeInsecure";
  const Motion = /** @type {any} */ (window).DeviceMotionEvent;
  if (!Motion) return "shakeNone";
  // Safari asks; others have a setting, which some do not tell.
  if (Motion.requestPermission) {
    const answer = await Motion.requestPermission().catch(() => "denied");
    return answer === "granted" ? null : "shakeRefused";
  }
  const setting = await navigator.permissions
    ?.query({ name: /** @type {any} */ ("accelerometer") }).catch(() => null);
  return setting?.state === "denied" ? "shakeRefused" : null;
}

/** Shaking, as it is switched on and off. */
export class Shake {
  /**
   * @param {() => Toy | null} toy
   * @param {() => void} changed called when the text or what shakes has changed
   */
  constructor(toy, changed) {
    this.toy = toy;
    this.changed = changed;
    this.text = "";
    /** @type {Sensor | null} */
    this.sensor = null;
    /** @type {Pointer | null} */
    this.pointer = null;
    this.number = 0;
    /** @type {{release(): Promise<void>} | null} what keeps the screen on while nobody touches it */
    this.awake = null;
    this.limitedAt = -Infinity;
    this.listen = this.listen.bind(this);
  }

  /** Whether the phone shakes the pivot, or will as soon as it has moved. */
  get isOn() {
    return this.sensor !== null;
  }

  /** Begin to shake, or end it. */
  async toggle() {
    if (this.isOn) {
      this.end();
      return;
    }
    this.number += 1;
    const { number } = this;
    const reason = await whyNot();
    if (number !== this.number) return;
    if (reason) {
      this.say(reason);
      return;
    }
    this.sensor = new Sensor();
    window.addEventListener("devicemotion", this.listen);
    void this.stayAwake();
    this.say("shakeWaits");
    setTimeout(() => {
      if (number === this.number && this.sensor?.time === -Infinity) this.end("shakeNone");
    }, PATIENCE);
  }

  /**
   * Leave the pivot to the cosine.
   * @param {string} [reason] name of a text
   */
  end(reason) {
    this.number += 1;
    window.removeEventListener("devicemotion", this.listen);
    this.sensor = null;
    void this.stayAwake();
    this.say(reason);
    this.apply();
  }

  /** Keep the screen on while a phone is shaken, where the browser can. */
  async stayAwake() {
    if (this.isOn) this.awake ??= await navigator.wakeLock?.request("screen").catch(() => null) ?? null;
    if (this.isOn) return;
    void this.awake?.release();
    this.awake = null;
  }

  /** @param {DeviceMotionEvent} event */
  listen({ accelerationIncludingGravity, timeStamp }) {
    const { sensor } = this;
    const { x, y, z } = accelerationIncludingGravity ?? {};
    // Devices without a sensor may report nothing, once.
    if (!sensor || typeof x !== "number" || typeof y !== "number" || typeof z !== "number") return;
    const isFirst = sensor.time === -Infinity;
    sensor.add(timeStamp, [x, y, z]);
    if (!isFirst) return;
    this.say("shakeNow");
    this.apply();
  }

  /**
   * Let a pointer drag the pivot to a height; null lets it go.
   * @param {number | null} height in m
   */
  drag(height) {
    const isNew = this.pointer === null;
    if (height === null) this.pointer = null;
    else {
      this.pointer ??= new Pointer();
      this.pointer.feed.add(performance.now(), height);
    }
    if (isNew || height === null) this.apply();
  }

  /** Give a toy what shakes it now. */
  apply() {
    const heard = this.sensor && this.sensor.time > -Infinity ? this.sensor : null;
    this.toy()?.shake(this.pointer ?? heard);
    this.changed();
  }

  /** Say what a person has to know about the shaking now. */
  watch() {
    const toy = this.toy();
    if (!toy?.isShaken) return;
    const now = performance.now();
    if (toy.shaken.isLimited) this.limitedAt = now;
    toy.shaken.isLimited = false;
    if (this.sensor && now - this.sensor.time > LOST) this.say("shakeLost");
    else if (now - this.limitedAt < SHOWN) this.say("shakeLimited");
    else this.say(this.sensor ? "shakeNow" : undefined);
  }

  /** @param {string} [name] of a text */
  say(name) {
    const limit = this.toy()?.shaken.limit ?? 0;
    const text = name ? t(name, { limit: (100 * limit).toPrecision(2) }) : "";
    if (text === this.text) return;
    this.text = text;
    this.changed();
  }
}
