import assert from "node:assert/strict";
import { test } from "node:test";

import { withControls } from "../../../src/latolato/app/static/js/toy/held_options.js";
import { GrowingMotion } from "../../../src/latolato/app/static/js/toy/growing_motion.js";

const REGISTRY = {
  drives: {
    harmonic: { options: ["drive_amplitude", "drive_frequency", "drive_phase"] },
    frequency_schedule: { options: ["drive_amplitude", "drive_times", "drive_frequencies", "ramp"] },
  },
  systems: {
    latolato: { options: ["length", "damping", "restitution"] },
    ballpair: { options: ["right_damping", "left_damping", "restitution"] },
  },
  options: Object.fromEntries(["drive_amplitude", "drive_frequency", "damping", "right_damping", "left_damping",
    "restitution"].map((name) => [name, { unit: "1", units: [] }])),
};
const CONTROLS = { drive_amplitude: 0.03, drive_frequency: 15.1, damping: 0.005, restitution: 0.9 };

test("the address of a toy that a hand holds is one of a harmonic drive", () => {
  const before = { drive: "frequency_schedule", drive_times: "0 s, 4 s", ramp: "1 s",
    frequency_ratios: "3, 2", length: "1 m" };
  const found = withControls(REGISTRY, before, "latolato", CONTROLS, "drive_amplitude");
  assert.deepEqual(found, {
    drive: "harmonic", length: "1 m", drive_amplitude: "0.03", drive_frequency: "15.1",
    damping: "0.005", restitution: "0.9",
  });
});

test("two free balls keep their own damping until it is touched", () => {
  const same = withControls(REGISTRY, {}, "ballpair", CONTROLS, "restitution");
  assert.equal("right_damping" in same, false);
  const found = withControls(REGISTRY, {}, "ballpair", CONTROLS, "damping");
  assert.equal(found.right_damping, "0.005");
  assert.equal(found.left_damping, "0.005");
});

test("a mirrored ball is drawn on the other side", () => {
  const ball = { length: 2, radius: 0.1, mass: 1 };
  const motion = new GrowingMotion({ time: 0, distances: [2], angles: [Math.PI / 2], velocities: [0],
    controls: { drive_amplitude: 0.1 }, pivot: { height: 0.05, velocity: 0, acceleration: 0 },
    system: { gravity: 9.8, contacts: true, balls: [ball] } });
  const [right, left] = motion.pose().balls;
  assert.deepEqual([right.ball.name, left.ball.name], ["right", "left"]);
  assert.ok(Math.abs(right.x - 2) < 1e-12 && Math.abs(left.x + 2) < 1e-12);
  assert.ok(Math.abs(right.y - 0.05) < 1e-12);
});
