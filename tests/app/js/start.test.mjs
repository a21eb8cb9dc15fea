// Where the balls of a run begin, as a pointer and keys choose it.
import assert from "node:assert/strict";
import test from "node:test";

import { poseOf } from "../../../src/latolato/app/static/js/player/motion.js";
import { anglesOf, angleLimits, rounded, withStart } from
  "../../../src/latolato/app/static/js/player/start.js";

const RADIANS = Math.PI / 180;
const ball = (name, row, sign) => ({ name, row, sign, length: 1, radius: 0.1, mass: 1 });
const PAIR = [ball("right", 0, 1), ball("left", 1, 1)];

test("a start replaces what else says where the balls begin", () => {
  const found = withStart({ length: "1 m", initial_offset: "1 mrad" }, {}, [20.5]);
  assert.deepEqual(found, { length: "1 m", initial_angle: "20.5 deg" });
});

test("balls that are led begin at rest", () => {
  const found = withStart({}, { initial_angular_velocity: [0, 0.3] }, [20, -30.1]);
  assert.deepEqual(found, { initial_angle: "20 deg, -30.1 deg",
    initial_angular_velocity: "0 rad/s, 0 rad/s" });
});

test("an angle is rounded into its limits", () => {
  assert.equal(rounded(12.34, [-Infinity, Infinity]), 12.3);
  assert.equal(rounded(5, [5.73, 174.27]), 5.8);
  assert.equal(rounded(200, [5.73, 174.27]), 174.2);
  // A limit that is round but for its last digit.
  assert.equal(rounded(0, [30.000000000000004, 150]), 30);
});

test("mirrored balls stop where they touch, below and above", () => {
  const motion = { about: {}, low: 0.1, high: Math.PI - 0.1 };
  const [low, high] = angleLimits(motion, [20], 0);
  assert.ok(Math.abs(low * RADIANS - 0.1) < 1e-12);
  assert.ok(Math.abs(high * RADIANS - (Math.PI - 0.1)) < 1e-12);
  assert.deepEqual(angleLimits({ about: {}, low: null, high: null }, [20], 0), [-Infinity, Infinity]);
});

test("each of two balls stops at the other", () => {
  const motion = { about: { attributes: { contact_separation: 10 * RADIANS } } };
  const near = (found, wanted) => found.forEach((each, i) => assert.ok(Math.abs(each - wanted[i]) < 1e-9));
  near(angleLimits(motion, [30, -20], 0), [-10, 330]);
  near(angleLimits(motion, [30, -20], 1), [-320, 20]);
});

test("whole turns are left out, of both balls alike", () => {
  const turned = poseOf(0, PAIR, ({ row }) => (row ? 700 : 760) * RADIANS);
  assert.deepEqual(anglesOf(turned), [40, -20]);
  const single = poseOf(0, [ball("ball", 0, 1)], () => -190.04 * RADIANS);
  assert.deepEqual(anglesOf(single), [170]);
});
