// A pivot that a phone or a hand shakes: how the sensor is read, and what the pivot makes of it.
import assert from "node:assert/strict";
import test from "node:test";

import { loadKernels, startKernels } from "../../../src/latolato/app/static/js/kernels/load.js";
import { MOST_ACCELERATION, ShakenDrive } from "../../../src/latolato/app/static/js/toy/drive.js";
import { FrameLoop } from "../../../src/latolato/app/static/js/toy/frame_loop.js";
import { Feed, Pointer, Sensor, Shake } from "../../../src/latolato/app/static/js/toy/shake.js";
import { Toy } from "../../../src/latolato/app/static/js/toy/toy.js";
import { t } from "../../../src/latolato/app/static/js/strings.js";

const one = await startKernels("one");
const shared = await loadKernels("one");
const GRAVITY = 9.8;
const BALL = { length: 0.245, mass: 0.106, damping: 0.005, radius: 0.0196, quadratic_damping: 0,
  coulomb_damping: 0 };
const LOW = Math.asin(BALL.radius / BALL.length);
const COSINE = { start: 0, amplitude: 0.03, frequency: 19.8, phase: 0 };
const FRAME = 1000 / 60; // ms
const GAINED = ["drive_work", "noise_work"];
const LOST = ["damping_loss", "impact_loss", "capture_loss"];

function latoLato(drive = COSINE) {
  const system = { kind: "latolato", angles: 1, contacts: true, linear: false, gravity: GRAVITY,
    restitution: 0.9, suspension: "rod", string_restitution: 0, drag_frame: "pivot", balls: [BALL], naturalFrequency: Math.sqrt(GRAVITY / BALL.length), low: LOW,
    high: Math.PI - LOW };
  const drives = { harmonic: { options: [] }, measured_pivot: { options: [] } };
  return new Toy(one, { kernels: shared, system, contact: "exact", restSpeed: 1e-7, frame: "pivot",
    registry: { systems: { latolato: { options: [] } }, drives, options: {}, ratios: {} },
    contactLimit: 1e6, angles: [LOW], velocities: [0], distances: [] }, drive);
}

/** A phone that is shaken along the vertical, with events that do not keep step with the frames. */
class Phone {
  constructor(sensor, { amplitude = 0.03, frequency = 19.8, up = [0, 1, 0], sign = 1, every = 16.9 } = {}) {
    Object.assign(this, { sensor, amplitude, frequency, up, sign, every, next: 0 });
  }

  acceleration(ms) {
    return -this.amplitude * this.frequency ** 2 * Math.cos((this.frequency * ms) / 1000);
  }

  /** Report what was measured up to an instant, a little late. */
  report(now) {
    for (; this.next <= now - 3; this.next += this.every) {
      const felt = this.sign * (GRAVITY + this.acceleration(this.next));
      this.sensor.add(this.next, this.up.map((each) => each * felt));
    }
  }
}

/** Move a toy on, frame by frame, while a phone reports. */
function shakeOn(toy, phone, seconds, after = () => {}) {
  const first = Math.round(toy.time * 60);
  for (let k = first + 1; k <= first + 60 * seconds; k += 1) {
    phone?.report(k * FRAME);
    toy.advance(k / 60, k * FRAME);
    after(toy);
  }
}

const rms = (values) => Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / values.length);
const slanted = [0.36, 0.48, 0.8];

for (const sign of [1, -1]) for (const [held, up] of Object.entries({ upright: [0, 1, 0],
  flat: [0, 0, 1], "upside down": [0, -1, 0], slanted })) {
  test(`a phone's vertical acceleration is found: ${held}, ${sign > 0 ? "Android" : "iOS"}`, () => {
    const sensor = new Sensor();
    const phone = new Phone(sensor, { up, sign });
    phone.report(4000);
    const found = [];
    const true_ = [];
    for (let now = 4000; now < 6000; now += FRAME) {
      phone.report(now);
      found.push(sensor.at(now).acceleration);
      true_.push(phone.acceleration(now - 25));
    }
    // The slow mean lags behind, by the share of the two frequencies.
    const errors = found.map((each, i) => each - true_[i]);
    assert.ok(rms(errors) < 0.12 * rms(true_), `${rms(errors) / rms(true_)}`);
    assert.ok(Math.abs(rms(found) / rms(true_) - 1) < 0.04);
  });
}

test("silence is said at once, also right after shaking was cut off", () => {
  const toy = { isShaken: true, shaken: { isLimited: true, limit: 0.1 } };
  const shake = new Shake(() => toy, () => {});
  shake.sensor = new Sensor();
  shake.sensor.time = performance.now();
  shake.watch();
  assert.equal(shake.text, t("shakeLimited", { limit: "10" }));
  shake.sensor.time -= 400;
  shake.watch();
  assert.equal(shake.text, t("shakeLost"));
});

for (const [amplitude, frequency] of [[0.03, 19.8], [0.05, 12.6], [0.02, 25], [0.1, 6.3]])
  test(`the pivot does what the phone does: ${amplitude} m at ${frequency} rad/s`, () => {
    const toy = latoLato();
    shakeOn(toy, null, 1);
    const sensor = new Sensor();
    toy.shake(sensor);
    const phone = new Phone(sensor, { amplitude, frequency });
    shakeOn(toy, phone, 6);
    const accelerations = [];
    const heights = [];
    shakeOn(toy, phone, 4, ({ pivot }) => {
      accelerations.push(pivot.acceleration);
      heights.push(pivot.height);
    });
    const true_ = amplitude / Math.SQRT2;
    // Samples are read linearly, twice.
    assert.ok(Math.abs(rms(accelerations) / (true_ * frequency ** 2) - 1) < 0.05);
    assert.ok(Math.abs(rms(heights) / true_ - 1) < 0.06);
    assert.ok(!toy.shaken.isLimited || amplitude === 0.1);
  });

test("shaking makes the balls clack", () => {
  const toy = latoLato({ ...COSINE, amplitude: 0 });
  const sensor = new Sensor();
  toy.shake(sensor);
  shakeOn(toy, new Phone(sensor, { amplitude: 0.05 }), 8);
  assert.ok(toy.contacts > 20);
});

test("height, velocity and acceleration of a shaken pivot are one motion, also where it changes hands", () => {
  const toy = latoLato();
  const sensor = new Sensor();
  const phone = new Phone(sensor, { amplitude: 0.06 });
  const pivots = [];
  const span = 1 / 480;
  for (let k = 1; k <= 480 * 4; k += 1) {
    if (k === 480) toy.shake(sensor);
    if (k === 480 * 3) toy.shake(null);
    phone.report((1000 * k) / 480);
    toy.advance(k / 480, (1000 * k) / 480);
    pivots.push(toy.pivot);
  }
  const strongest = Math.max(...pivots.map(({ acceleration }) => Math.abs(acceleration)));
  assert.ok(strongest < 60);
  for (let k = 1; k < pivots.length; k += 1) {
    const [before, now] = [pivots[k - 1], pivots[k]];
    assert.ok(Math.abs(now.velocity - before.velocity) <= (strongest + 20) * span);
    const way = 0.5 * (now.velocity + before.velocity) * span;
    assert.ok(Math.abs(now.height - before.height - way) < (strongest + 20) * 30 * span ** 3);
  }
  // The cosine is back.
  assert.ok(toy.drive.isSteady && toy.drive.cosine.amplitude === COSINE.amplitude);
});

test("the ledger of a shaken toy closes, and what is kept has the heights of the pivot", () => {
  const toy = latoLato();
  const sensor = new Sensor();
  const phone = new Phone(sensor, { amplitude: 0.05 });
  shakeOn(toy, phone, 1);
  toy.shake(sensor);
  const heights = [];
  shakeOn(toy, phone, 6, ({ pivot }) => heights.push(pivot.height));
  const recording = toy.minute.keep(toy.system, 0);
  assert.ok(recording.isShaken && !recording.byHand);
  assert.equal(recording.again(), null);
  const columns = recording.columns();
  const sum = (names) => names.reduce((total, each) => total + (columns[each]?.[0].at(-1) ?? 0), 0);
  const [total] = columns.total_energy;
  const error = total.at(-1) - total[0] - sum(GAINED) + sum(LOST);
  assert.ok(Math.max(...total) > 0.05, `${Math.max(...total)}`);
  assert.ok(Math.abs(error) < 1e-9 * Math.max(...total), `${error}`);
  const recorded = columns.pivot_height[0];
  assert.equal(recorded.at(-1), heights.at(-1));
  assert.equal(recorded.at(-5), heights.at(-2));
  assert.equal(recording.options().drive, "measured_pivot");
});

test("a sensor that falls silent lets the pivot come to rest", () => {
  const toy = latoLato();
  const sensor = new Sensor();
  toy.shake(sensor);
  shakeOn(toy, new Phone(sensor, { amplitude: 0.05 }), 4);
  const jumps = [];
  let before = toy.pivot;
  shakeOn(toy, null, 4, ({ pivot }) => {
    jumps.push(Math.abs(pivot.velocity - before.velocity));
    before = pivot;
  });
  assert.ok(Math.max(...jumps) < 25 / 60, `${Math.max(...jumps)}`);
  assert.ok(Math.abs(toy.pivot.height) < 1e-3 && Math.abs(toy.pivot.acceleration) < 1e-2);
});

for (const [amplitude, frequency] of [[0.3, 12.6], [0.15, 19], [0.12, 25], [0.13, 9]])
  test(`stronger shaking is cut off: ${amplitude} m at ${frequency} rad/s`, () => {
    const toy = latoLato();
    const { limit } = toy.shaken;
    const sensor = new Sensor();
    toy.shake(sensor);
    let [highest, strongest] = [0, 0];
    shakeOn(toy, new Phone(sensor, { amplitude, frequency }), 10, ({ pivot }) => {
      highest = Math.max(highest, Math.abs(pivot.height));
      strongest = Math.max(strongest, Math.abs(pivot.acceleration));
    });
    assert.ok(toy.shaken.isLimited);
    assert.ok(highest < 1.1 * limit, `${highest}`);
    assert.ok(strongest <= MOST_ACCELERATION + 1e-9);
  });

test("a cosine faster than any shaking is stopped", () => {
  const toy = latoLato({ ...COSINE, amplitude: 0.12, frequency: 200 });
  shakeOn(toy, null, 0.5);
  toy.shake(new Sensor());
  shakeOn(toy, null, 8);
  assert.ok(Math.abs(toy.pivot.height) < 0.01);
});

test("a pivot that is dragged follows the pointer without swinging past it", () => {
  const toy = latoLato();
  const pointer = new Pointer();
  pointer.feed.add(0, 0.08);
  toy.shake(pointer);
  let highest = -1;
  shakeOn(toy, null, 1.5, ({ pivot }) => { highest = Math.max(highest, pivot.height); });
  assert.ok(Math.abs(toy.pivot.height - 0.08) < 1e-6);
  assert.ok(highest < 0.081);
  pointer.feed.add(1500, 5); // beyond what is allowed
  shakeOn(toy, null, 1.5);
  assert.ok(Math.abs(toy.pivot.height - toy.shaken.limit) < 1e-4);
  assert.ok(toy.shaken.isLimited);
});

test("every step of a picture knows its own instant of the page's clock", () => {
  const steps = [];
  const toy = { time: 0, advance(stop, wall) {
    this.time = stop;
    steps.push([stop, wall]);
  } };
  const pace = new FrameLoop(() => 0);
  pace.speed = 0.5;
  pace.move(toy, 1000, () => {});
  pace.move(toy, 1050, () => {});
  assert.equal(steps.length, 2);
  for (const [stop, wall] of steps) assert.ok(Math.abs(wall - 1000 - 2000 * stop) < 1e-9);
});

test("a feed is linear between its samples and constant beyond them", () => {
  const feed = new Feed();
  assert.equal(feed.at(0).age, Infinity);
  feed.add(100, 1);
  feed.add(100, 7); // the same instant once more
  feed.add(120, 3);
  assert.deepEqual([110, 125, 135, 145, 500].map((now) => feed.at(now).value), [1, 1, 2, 3, 3]);
  assert.equal(feed.at(150).age, 30);
});

test("a drive without a toy keeps to its formula", () => {
  const drive = new ShakenDrive({ take: () => ({}), set: () => {} }, 0.12);
  drive.begin({ height: 0.02, velocity: -0.1, acceleration: 3 },
    { rate: 2, dampingRatio: 0.5, at: () => ({ acceleration: 0, height: 0 }) });
  for (let k = 0; k < 60 * 12; k += 1) drive.move(k / 60, (k + 1) / 60, 0);
  assert.ok(Math.abs(drive.pivot.height) < 1e-4);
});
