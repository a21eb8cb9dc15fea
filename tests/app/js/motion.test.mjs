// The state between samples and around contacts.
import assert from "node:assert/strict";
import test from "node:test";

import { before, Motion, range } from "../../../src/latolato/app/static/js/player/motion.js";
import { crank } from "../../../src/latolato/app/static/js/player/pivot.js";

const BALLS = [
  { name: "right", row: 0, sign: 1, length: 1, radius: 0.1, mass: 1 },
  { name: "left", row: 0, sign: -1, length: 1, radius: 0.1, mass: 1 },
];

/** A ball that falls onto a wall at 0.1 rad at t = 0.5 and rises as fast, straight lines. */
function bounce() {
  const time = Float64Array.from({ length: 11 }, (_, i) => i / 10 + 0.03);
  const angle = Float32Array.from(time, (t) => 0.1 + Math.abs(t - 0.5));
  const rate = Float32Array.from(time, (t) => Math.sign(t - 0.5));
  return new Motion({
    about: { balls: BALLS, options: { drive: "harmonic", drive_frequency: 2 * Math.PI * 4 },
      attributes: { contact_angle_low: 0.1, contact_angle_high: 3 } },
    arrays: {
      time, angle, angular_velocity: rate, pivot_height: new Float32Array(11),
      contact_time: new Float64Array([0.5]), contact_kind: new Uint8Array([0]),
      angular_velocity_before: new Float32Array([-1]), angular_velocity_after: new Float32Array([1]),
    },
    shapes: { time: [11], angle: [1, 11], angular_velocity: [1, 11], pivot_height: [1, 11],
      contact_time: [1], contact_kind: [1], angular_velocity_before: [1, 1],
      angular_velocity_after: [1, 1] },
  });
}

test("the ball turns round at the instant of the contact, not at a sample", () => {
  const motion = bounce();
  for (let t = 0.03; t < 1.03; t += 0.0007) {
    const wanted = 0.1 + Math.abs(t - 0.5);
    assert.ok(Math.abs(motion.angle(BALLS[0], t) - wanted) < 1e-6, `at ${t}`);
    assert.ok(Math.abs(motion.angle(BALLS[1], t) + wanted) < 1e-6, `left at ${t}`);
  }
});

test("a run that stopped early ends at its last sample", () => {
  const whole = bounce();
  whole.block.arrays.angle.fill(NaN, 8);
  whole.block.arrays.angular_velocity.fill(NaN, 8);
  whole.block.arrays.strobe = Float64Array.from([0.25, 0.5, 0.75, 1]);
  const motion = new Motion(whole.block);
  assert.equal(motion.end, whole.time[7]);
  assert.deepEqual(motion.strobes(), [0.25, 0.5]);
  assert.equal(motion.values("angle").length, motion.time.length);
  assert.ok(Math.abs(motion.angle(BALLS[0], motion.end) - (0.1 + motion.end - 0.5)) < 1e-6);
});

test("a pose puts the ball on its rod below the pivot", () => {
  const { balls } = bounce().pose(0.9);
  assert.ok(Math.abs(balls[0].x - Math.sin(0.5)) < 1e-6);
  assert.ok(Math.abs(balls[0].y + Math.cos(0.5)) < 1e-6);
  assert.equal(balls[1].x, -balls[0].x);
});

test("before finds the last value that does not exceed another", () => {
  assert.equal(before([0, 1, 2], 1.5), 1);
  assert.equal(before([0, 1, 2], -1), 0);
  assert.equal(before([0, 1, 2], 9), 2);
});

test("range leaves out what is no number", () => {
  assert.deepEqual(range([NaN, 2, -1]), [-1, 2]);
  assert.deepEqual(range([]), [0, 0]);
});

test("the rod of a crank keeps its length", () => {
  for (const guide of ["below", "above"]) {
    const side = guide === "below" ? -1 : 1;
    for (let t = 0; t < 1; t += 0.05) {
      const options = { guide, drive_amplitude: 0.02, connecting_rod_length: 0.1,
        drive_frequency: 7, drive_phase: 0.3 };
      const { pin } = crank(options, t);
      const p = 7 * t + 0.3;
      const x = 0.02 * Math.sin(p);
      const height = 0.02 * Math.cos(p) + side * (Math.sqrt(0.1 ** 2 - x * x) - 0.1);
      assert.ok(Math.abs(Math.hypot(pin[0], pin[1] - height) - 0.1) < 1e-12, guide);
    }
  }
});
