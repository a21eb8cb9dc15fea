import assert from "node:assert/strict";
import { test } from "node:test";

import { withControls } from "../../../src/latolato/app/static/js/live/address.js";
import { History, LiveMotion, SPAN } from "../../../src/latolato/app/static/js/live/motion.js";

const REGISTRY = {
  drives: {
    harmonic: { options: ["drive_amplitude", "drive_frequency", "drive_phase"] },
    frequency_schedule: { options: ["drive_amplitude", "drive_times", "drive_frequencies", "ramp"] },
  },
  systems: {
    latolato: { options: ["length", "damping", "restitution"] },
    ballpair: { options: ["right_damping", "left_damping", "restitution"] },
  },
};
const CONTROLS = { drive_amplitude: 0.03, drive_frequency: 15.1, damping: 0.005, restitution: 0.9 };

test("the address of a live toy is one of a harmonic drive", () => {
  const before = { drive: "frequency_schedule", drive_times: "0 s, 4 s", ramp: "1 s",
    frequency_ratios: "3, 2", length: "1 m" };
  const found = withControls(REGISTRY, before, "latolato", CONTROLS, "drive_amplitude");
  assert.deepEqual(found, {
    drive: "harmonic", length: "1 m", drive_amplitude: "0.03 m", drive_frequency: "15.1 rad/s",
    damping: "0.005 kg m/s", restitution: "0.9",
  });
});

test("two free balls keep their own damping until it is touched", () => {
  const same = withControls(REGISTRY, {}, "ballpair", CONTROLS, "restitution");
  assert.equal("right_damping" in same, false);
  const found = withControls(REGISTRY, {}, "ballpair", CONTROLS, "damping");
  assert.equal(found.right_damping, "0.005 kg m/s");
  assert.equal(found.left_damping, "0.005 kg m/s");
});

test("the history keeps the last seconds in their order", () => {
  const history = new History(["right"]);
  for (let k = 0; k < 2000; k += 1) history.add(k / 60, { right: k });
  const first = history.time[history.at(0)];
  const last = history.time[history.at(history.count - 1)];
  assert.equal(last, 1999 / 60);
  assert.ok(last - first >= SPAN && last - first < SPAN + 1.1);
  assert.deepEqual(history.range(["right"]), [2000 - history.count, 1999]);
});

test("a history begins again when time goes back", () => {
  const history = new History(["right"]);
  for (let k = 0; k < 50; k += 1) history.add(k, { right: 100 });
  history.add(0, { right: 1 });
  assert.equal(history.count, 1);
  assert.deepEqual(history.range(["right"]), [1, 1]);
});

test("a history leaves out what no picture can show", () => {
  const history = new History(["right"]);
  for (let k = 0; k < 4000; k += 1) history.add(k / 240, { right: k });
  const last = history.time[history.at(history.count - 1)];
  assert.ok(last - history.time[history.at(0)] >= SPAN);
});

test("a mirrored ball is drawn on the other side", () => {
  const ball = { length: 2, radius: 0.1, mass: 1 };
  const motion = new LiveMotion({ time: 0, distances: [2], angles: [Math.PI / 2], velocities: [0],
    controls: { drive_amplitude: 0.1 }, pivot: { height: 0.05, velocity: 0, acceleration: 0 },
    system: { gravity: 9.8, contacts: true, balls: [ball] } }, new History([]));
  const [right, left] = motion.pose().balls;
  assert.deepEqual([right.ball.name, left.ball.name], ["right", "left"]);
  assert.ok(Math.abs(right.x - 2) < 1e-12 && Math.abs(left.x + 2) < 1e-12);
  assert.ok(Math.abs(right.y - 0.05) < 1e-12);
});

test("a trail goes through what the history has of the last moment", () => {
  const history = new History(["right", "left", "far", "other", "pivot"]);
  for (let k = 0; k < 60; k += 1)
    history.add(k / 60, { right: k, left: -k, far: 2, other: 2, pivot: 0.001 * k });
  const ball = { length: 2, radius: 0.1, mass: 1 };
  const motion = new LiveMotion({ time: 1, distances: [2], angles: [Math.PI / 3], velocities: [0],
    controls: { drive_amplitude: 0.1 }, pivot: { height: 0.06, velocity: 0, acceleration: 0 },
    system: { gravity: 9.8, contacts: true, balls: [ball] } }, history);
  const poses = motion.recent(1, 5.5 / 60);
  assert.equal(poses.length, 10); // five instants, one between each two, and now
  poses.slice(0, -1).forEach(({ height, balls: [right, left] }, i) => {
    const k = 55 + 0.5 * i;
    const angle = (k * Math.PI) / 180;
    assert.ok(Math.abs(height - 0.001 * k) < 1e-12);
    assert.ok(Math.abs(right.x - 2 * Math.sin(angle)) < 1e-12);
    assert.ok(Math.abs(left.x + right.x) < 1e-12);
    assert.ok(Math.abs(right.y - (height - 2 * Math.cos(angle))) < 1e-12);
  });
  assert.equal(poses.at(-1).height, 0.06);
});
