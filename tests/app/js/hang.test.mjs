// Arcs of slack strings, and where balls are on them.
import assert from "node:assert/strict";
import test from "node:test";

import { sagOf } from "../../../src/latolato/app/static/js/player/hang.js";
import { Motion } from "../../../src/latolato/app/static/js/player/motion.js";

/** The length of an arc that hangs this far below its chord, from many short lines. */
function lengthOf(across, rise, sag) {
  const parts = 20_000;
  const at = (t) => [across * t, rise * t - 4 * sag * t * (1 - t)];
  let sum = 0;
  for (let k = 0; k < parts; k += 1) {
    const [[x0, y0], [x1, y1]] = [at(k / parts), at((k + 1) / parts)];
    sum += Math.hypot(x1 - x0, y1 - y0);
  }
  return sum;
}

test("an arc is as long as its string, also one whose ends lie above or upon each other", () => {
  for (const [across, rise] of [[0.5, -0.3], [-0.5, 0.3], [0, -0.8], [0, 0.8], [0, 0], [0.7, 0], [0.6, -0.79]]) {
    const sag = sagOf(across, rise, 1);
    assert.ok(Math.abs(lengthOf(across, rise, sag) - 1) < 1e-6, `${across}, ${rise}`);
  }
});

test("a string that is just taut hangs in no arc", () => {
  assert.ok(sagOf(0.6, -0.8, 1) < 1e-6);
});

const BALL = { name: "ball", row: 0, sign: 1, length: 1, radius: 0, mass: 1 };

/** A ball that flies straight past the pivot at 0.2 m, with a pivot that moves to the right. */
function flight() {
  const time = Float64Array.from({ length: 9 }, (_, i) => i / 10);
  const x = Array.from(time, (t) => 1.6 * t - 0.6);
  const distance = Float64Array.from(x, (each) => Math.hypot(each, 0.2));
  const arrays = { time, distance, angle: Float64Array.from(x, (each) => Math.atan2(each, 0.2)),
    angular_velocity: Float64Array.from(x, (each, i) => (1.6 * 0.2) / distance[i] ** 2),
    radial_velocity: Float64Array.from(x, (each, i) => (1.6 * each) / distance[i]),
    slack: new Float64Array(9).fill(1), pivot_height: new Float64Array(9),
    pivot_across: Float64Array.from(time, (t) => 0.1 * t), contact_time: new Float64Array(0),
    contact_kind: new Uint8Array(0) };
  const shapes = Object.fromEntries(Object.entries(arrays).map(([name, { length }]) => [name, [1, length]]));
  return new Motion({ about: { balls: [BALL], options: {}, attributes: { natural_frequency: 3 } }, arrays, shapes });
}

test("a ball on a slack string flies where it is, not on its circle", () => {
  const motion = flight();
  for (let t = 0; t < 0.8; t += 0.013) {
    const { across, balls: [{ x, y, distance }] } = motion.pose(t);
    assert.ok(Math.abs(across - 0.1 * t) < 1e-12);
    assert.ok(Math.abs(x - across - (1.6 * t - 0.6)) < 1e-9 && Math.abs(y + 0.2) < 1e-9);
    assert.ok(Math.abs(distance - Math.hypot(1.6 * t - 0.6, 0.2)) < 1e-9);
  }
  const { left, right } = motion.box(0.4);
  assert.ok(left <= -0.6 && right >= 0.7 && right < 1);
});
