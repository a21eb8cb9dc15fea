// A toy that is steered while it moves: what a hand may do, and what stays true whatever it does.
import assert from "node:assert/strict";
import test from "node:test";

import { loadKernels, startKernels } from "../../../src/latolato/app/static/js/kernels/load.js";
import { SHORTEST_CHANGE } from "../../../src/latolato/app/static/js/toy/drive.js";
import { SAME } from "../../../src/latolato/app/static/js/toy/minute.js";
import { MOST_BEHIND, FrameLoop } from "../../../src/latolato/app/static/js/toy/frame_loop.js";
import { GrowingMotion } from "../../../src/latolato/app/static/js/toy/growing_motion.js";
import { learnRules } from "../../../src/latolato/app/static/js/model/rules.js";
import { Toy } from "../../../src/latolato/app/static/js/toy/toy.js";

learnRules({ at_least: { rule: "must lie in {range}", way_out: "" }, at_most: { rule: "must lie in {range}", way_out: "" } });
const upright = [await startKernels("one"), await startKernels("two")];
const inPlane = [await startKernels("plane_one"), await startKernels("plane_two")];
const shared = { rod: await loadKernels("one"), string: await loadKernels("plane_one") }; // for runs
const registry = { systems: { latolato: { options: [] }, pendulum: { options: [] } } };
const DRAGS = { quadratic_damping: 0, coulomb_damping: 0 };
const BALL = { length: 0.245, mass: 0.106, damping: 0.005, radius: 0.0196, ...DRAGS };
const LOW = Math.asin(BALL.radius / BALL.length);
const OTHER = { ...BALL, length: 0.24, mass: 0.15, radius: 0.0225 };
const COSINE = { start: 0, amplitude: 0.03, frequency: 19.8, phase: 0 };
const STILL = { ...COSINE, amplitude: 0 };
const LEDGER = { gained: ["drive_work", "noise_work"],
  lost: ["damping_loss", "impact_loss", "capture_loss"] };

function toyOf({ balls = [BALL], contacts = true, restitution = 0.9, angles, velocities,
  drive = COSINE, linear = false, suspension = "rod" }) {
  const system = { kind: balls.length > 1 ? "ballpair" : contacts ? "latolato" : "pendulum",
    angles: balls.length, contacts, linear, gravity: 9.8, restitution, balls, suspension,
    string_restitution: 0, drag_frame: "pivot",
    naturalFrequency: Math.sqrt(9.8 / balls[0].length), low: LOW, high: Math.PI - LOW };
  const each = { kernels: shared[suspension], registry, system, contact: "exact", restSpeed: 1e-7, frame: "pivot",
    contactLimit: 1e6, angles, velocities: velocities ?? angles.map(() => 0), distances: [] };
  const modules = suspension === "string" ? inPlane : upright;
  return new Toy(modules[balls.length - 1], each, drive);
}
const pairOf = (more = {}) => toyOf({ balls: [BALL, OTHER], angles: [0.5, -0.4], ...more });
const latoLato = (more = {}) => toyOf({ angles: [LOW], ...more });
const pendulum = (more = {}) => toyOf({ contacts: false, angles: [0.3], ...more });

const keep = (toy, since) => toy.minute.keep(toy.system, since);

function runOn(toy, seconds, after = () => {}) {
  const begun = toy.time;
  for (let k = 1; k <= Math.round(60 * seconds); k += 1) {
    toy.advance(begun + k / 60);
    after(toy);
  }
}

const gapOf = ({ angles: [right, left = 0] }) => right - left;

test("weak shaking leaves the balls at rest, strong shaking lifts them off again and again", () => {
  for (const [amplitude, rests] of [[0.005, true], [0.04, false]]) {
    const toy = latoLato({ restitution: 0, drive: { ...COSINE, amplitude } });
    let moved = false;
    runOn(toy, 2, () => { moved ||= toy.angles[0] !== toy.walls[0]; });
    assert.equal(moved, !rests);
    const kinds = [...keep(toy, 0).contactColumns().contact_kind[0]];
    for (const kind of [2, 3]) assert.equal(kinds.filter((each) => each === kind).length > 3, !rests);
  }
});

for (const changes of [{ drive_frequency: 15.1 }, { drive_amplitude: 0.04 }, { drive_amplitude: 0 },
  { drive_amplitude: 0.04, drive_frequency: 30 }]) {
  test(`the pivot never jumps: ${JSON.stringify(changes)}`, () => {
    const toy = latoLato();
    const pivots = [];
    const span = 1 / 480;
    runOn(toy, 0.5);
    for (let k = 0; k < 480; k += 1) {
      if ([40, 48, 160].includes(k)) // again before the first change has ended
        toy.set(k === 48 ? { drive_amplitude: 0.01 } : changes);
      toy.advance(toy.time + span);
      pivots.push(toy.pivot);
    }
    const strongest = Math.max(...pivots.map(({ acceleration }) => Math.abs(acceleration)));
    assert.ok(strongest < 0.04 * 30 ** 2 + 60);
    for (let k = 1; k < pivots.length; k += 1) {
      const [before, now] = [pivots[k - 1], pivots[k]];
      assert.ok(Math.abs(now.velocity - before.velocity) <= (strongest + 20) * span);
      const way = 0.5 * (now.velocity + before.velocity) * span;
      assert.ok(Math.abs(now.height - before.height - way) < (strongest + 20) * 30 * span ** 3);
    }
  });
}

test("a small change is done within the least time, and a later one goes on from it", () => {
  const toy = latoLato();
  toy.set({ drive_amplitude: 0.031 });
  assert.equal(toy.drive.changes[0].ramp, SHORTEST_CHANGE);
  runOn(toy, 0.1);
  assert.ok(toy.drive.isSteady);
  assert.equal(toy.drive.cosine.amplitude, 0.031);
  toy.set({ drive_amplitude: 0.05 });
  toy.set({ drive_amplitude: 0.03 }); // at the same instant: the last counts
  assert.equal(toy.drive.changes.length, 1);
  runOn(toy, 0.5);
  assert.equal(toy.drive.cosine.amplitude, 0.03);
});

test("a push gives the energy of its speed, to both balls of a pair", () => {
  const free = { drive: STILL, balls: [{ ...BALL, damping: 0 }] };
  for (const [make, balls] of [[pendulum, 1], [latoLato, 2]]) {
    const toy = make({ ...free, angles: [LOW] });
    const motion = new GrowingMotion(toy);
    const sum = (name) => motion.balls.reduce((total, { row }) => total + motion.at(name, 0, row), 0);
    const before = sum("potential_energy");
    toy.push(2);
    runOn(toy, 0.1);
    const [kinetic, potential] = ["kinetic_energy", "potential_energy"].map(sum);
    const energy = balls * 0.5 * BALL.mass * (2 * BALL.length) ** 2;
    assert.ok(Math.abs(kinetic + potential - before - energy) < 1e-9 * energy);
  }
});

for (const [name, make, ball] of [["pair", latoLato, 0], ["pendulum", pendulum, 0], ["two balls", pairOf, 1]]) {
  test(`a held ball goes where the hand goes, and is free again: ${name}`, () => {
    const toy = make({ drive: STILL });
    const angle = ball ? -1 : 1.2;
    toy.hold({ ball, angle });
    runOn(toy, 1.5);
    // The hand corrects sixty times a second, and for the fall in between.
    assert.ok(Math.abs(toy.angles[ball] - angle) < 2e-3);
    toy.hold(null);
    runOn(toy, 0.5);
    assert.ok(Math.abs(toy.angles[ball] - angle) > 0.05);
  });
}

test("a ball that is pressed on the wall rests there", () => {
  const toy = latoLato({ drive: STILL });
  toy.hold({ ball: 0, angle: 1 });
  runOn(toy, 1);
  toy.hold({ ball: 0, angle: -3 });
  runOn(toy, 2);
  const before = toy.contacts;
  runOn(toy, 1);
  assert.equal(toy.contacts, before);
  assert.equal(toy.angles[0], toy.walls[0]);
});

test("whatever is done the balls stay between their contacts", () => {
  let seed = 1;
  const random = () => { // Lehmer's generator
    seed = (48271 * seed) % 2147483647;
    return seed / 2147483647;
  };
  for (const make of [latoLato, pairOf]) for (let trial = 0; trial < 15; trial += 1) {
    const toy = make();
    for (let action = 0; action < 8; action += 1) {
      for (const [name, [low, high]] of Object.entries(toy.limits))
        if (random() < 0.4) toy.set({ [name]: low + random() * (high - low) });
      if (random() < 0.3) toy.push(40 * random() - 20);
      if (random() < 0.5) toy.hold({ ball: 0, angle: 14 * random() - 7 });
      else toy.hold(null);
      runOn(toy, 0.2, () => {
        const [low, high] = toy.walls;
        assert.ok(gapOf(toy) >= low - 1e-9 && gapOf(toy) <= high + 1e-9);
      });
    }
  }
});

for (const values of [{ drive_frequency: 1e8 }, { drive_amplitude: NaN }, { drive_amplitude: -0.01 },
  { damping: Infinity }, { restitution: 1.01 }, { restitution: "0.5" }, { mass: 1 }]) {
  test(`a value beyond its limits is refused, and all others with it: ${Object.entries(values)}`, () => {
    const toy = latoLato();
    const before = { ...toy.controls };
    assert.throws(() => toy.set({ drive_amplitude: 0.01, ...values }), /must lie in|unknown control/);
    assert.deepEqual(toy.controls, before);
  });
}

test("changes of the drive make a run that comes out again", () => {
  const toy = latoLato({ drive: { ...COSINE, amplitude: 0.034 } });
  runOn(toy, 5);
  const since = toy.time;
  runOn(toy, 1);
  toy.set({ drive_frequency: 15.1 });
  runOn(toy, 0.1);
  toy.set({ drive_amplitude: 0.028 }); // before the first change has ended
  runOn(toy, 2);
  const kept = keep(toy, since);
  assert.equal(kept.byHand, false);
  assert.equal(kept.changes.length, 2);
  assert.ok(kept.deviation(kept.again()) < SAME);
  assert.ok(Math.abs(kept.duration - 3.1) < 1e-9);
  kept.changes.pop();
  assert.ok(kept.deviation(kept.again()) > SAME);
});

for (const [name, act] of [["push", (toy) => toy.push(1)],
  ["drag", (toy) => toy.hold({ ball: 0, angle: 1 })],
  ["damping", (toy) => toy.set({ damping: 0.01 })]]) {
  test(`what a hand did is kept, with its work: ${name}`, () => {
    const toy = latoLato({ drive: { ...COSINE, amplitude: 0.034 } });
    runOn(toy, 3);
    const since = toy.time;
    runOn(toy, 0.5);
    assert.equal(keep(toy, since).byHand, false);
    act(toy);
    runOn(toy, 1);
    const kept = keep(toy, since);
    assert.ok(kept.byHand);
    const columns = kept.columns();
    assert.equal(columns.angle[0].at(-1), toy.angles[0]);
    // What came in, the hand's work too, is what went out and what is left.
    const sum = (names) => names.reduce((total, each) => total + (columns[each]?.[0].at(-1) ?? 0), 0);
    const [total] = columns.total_energy;
    const error = total.at(-1) - total[0] - sum(LEDGER.gained) + sum(LEDGER.lost);
    assert.ok(Math.abs(error) < 1e-6 * Math.max(...total));
  });
}

test("a chaotic motion is not found again", () => {
  const toy = pendulum({ angles: [1], drive: { ...COSINE, amplitude: 0.1, frequency: 12.6 } });
  runOn(toy, 60);
  const kept = keep(toy, 0);
  assert.ok(kept.deviation(kept.again()) > SAME);
});

test("what is kept begins with a steady drive and a free ball", () => {
  const toy = latoLato();
  runOn(toy, 1);
  toy.set({ drive_amplitude: 0.06 });
  runOn(toy, 0.5);
  toy.hold({ ball: 0, angle: 1 });
  runOn(toy, 0.5);
  toy.hold(null);
  runOn(toy, 1);
  for (const [since, starts] of [[0.5, 0.5], [1, null], [1.55, 2]]) {
    const { start, changes, byHand } = keep(toy, since);
    if (starts === null) assert.ok(start > 1 && start < 1.5, `${start}`);
    else assert.ok(Math.abs(start - starts) < 0.02, `${start}`);
    assert.equal(changes.length, since < 1 ? 1 : 0);
    assert.equal(byHand, since < 2 && start < 2);
  }
});

test("what is kept is the last minute, and exact though the rest is forgotten", () => {
  const toy = latoLato({ drive: { ...COSINE, amplitude: 0.034 } });
  runOn(toy, 61);
  toy.set({ drive_frequency: 15.1 });
  runOn(toy, 130); // by now samples were forgotten
  const { start, duration, cosine } = keep(toy);
  assert.ok(Math.abs(duration - 60) < 1 / 240 && Math.abs(start - 131) < 1 / 240);
  assert.equal(cosine.frequency, 15.1);
  assert.ok(toy.minute.samples.length <= 2 * 60 * 240);
  const kept = keep(toy, toy.time - 1);
  assert.ok(kept.deviation(kept.again()) < SAME);
  const recent = toy.minute.recent("angle", 0, 15, 4);
  assert.equal(recent.length, 901);
});

test("samples lie on their grid and contacts in their order, whatever the frames are", () => {
  const toy = latoLato({ drive: { ...COSINE, amplitude: 0.04 } });
  toy.advance(0.0131);
  for (let k = 0; toy.time < 6; k += 1) toy.advance(toy.time + [0.0007, 0.0166, 1 / 144][k % 3]);
  const kept = keep(toy, 0.0131);
  const { start } = kept;
  const times = [...kept.columns().time[0]];
  assert.equal(times[0], 0);
  times.slice(1).forEach((time, i) => assert.ok(Math.abs((time + start) * 240 - i - 5) < 1e-9));
  const { contact_time: [instants], contact_kind: [kinds] } = kept.contactColumns();
  assert.ok(instants.length > 20);
  assert.ok(instants.every((time, i) => i === 0 || time >= instants[i - 1]));
  assert.ok(kinds.includes(0));
});

test("memory does not grow while a toy moves, is steered and kept", () => {
  const toy = latoLato();
  runOn(toy, 1);
  const { top } = upright[0];
  toy.set({ drive_frequency: 15.1, damping: 0.004 });
  toy.push(1);
  runOn(toy, 3);
  keep(toy, 0).again();
  assert.equal(upright[0].top, top);
});

test("a toy on strings goes slack and taut, and moves as the run of what is kept", () => {
  const toy = latoLato({ suspension: "string", drive: { ...COSINE, amplitude: 0.05 } });
  const far = [];
  runOn(toy, 2, () => far.push(toy.distances[0]));
  assert.ok(Math.min(...far) < 0.9 * BALL.length && Math.max(...far) <= BALL.length * (1 + 1e-12));
  const kept = keep(toy, 0);
  const { contact_kind: [kinds], radial_velocity_before: [before] } = kept.contactColumns();
  for (const kind of [0, 4, 5]) assert.ok(kinds.includes(kind));
  kinds.forEach((kind, i) => assert.ok(kind !== 5 || before[i] > 0));
  const again = kept.again();
  assert.ok(kept.deviation(again) < SAME);
  const { distance: [seen], retension_loss: [lost] } = kept.columns();
  seen.forEach((each, i) => assert.ok(Math.abs(each - again.columns.distance[0][i]) < SAME));
  assert.ok(Math.abs(lost.at(-1) - again.columns.retension_loss[0].at(-1)) < 1e-9 && lost.at(-1) > 0);
});

test("balls on strings that are not described say so", () => {
  const toy = pairOf({ suspension: "string", drive: { ...COSINE, amplitude: 0.06 } });
  assert.throws(() => runOn(toy, 60), /is not described/);
});

test("a motion that cannot be followed says so", () => {
  const toy = pendulum();
  toy.push(1e9);
  assert.throws(() => runOn(toy, 0.1), /cannot be followed/);
});

/** A pace on a clock that a toy's own moves let pass. */
function paced(costs) {
  const clock = { now: 0 };
  const pace = new FrameLoop(() => clock.now);
  const toy = { time: 0, advance(stop) {
    assert.ok(stop - this.time <= 1 / 60 + 1e-12);
    this.time = stop;
    clock.now += costs;
  } };
  const show = (now) => {
    clock.now = Math.max(clock.now, now);
    pace.move(toy, now, () => {});
  };
  return { pace, toy, show };
}

test("a toy keeps real time, at every speed and rate of pictures", () => {
  for (const [speed, rate] of [[1, 60], [1, 144], [0.1, 60], [10, 60], [10, 30]]) {
    const { pace, toy, show } = paced(0.1);
    pace.speed = speed;
    for (let k = 0; k <= 2 * rate; k += 1) show((1000 * k) / rate);
    assert.ok(Math.abs(toy.time - 2 * speed) < 1e-9);
    assert.ok(Math.abs(pace.share - 1) < 1e-9);
  }
});

test("a machine that cannot follow slows the toy down and says how much", () => {
  const { pace, toy, show } = paced(10);
  pace.speed = 10;
  for (let k = 0; k <= 120; k += 1) show((1000 * k) / 60);
  assert.ok(toy.time > 2 && toy.time < 8);
  assert.ok(pace.share < 0.5);
});

test("a toy that was held up goes on from where it is", () => {
  const { pace, toy, show } = paced(0);
  show(0);
  show(10_000);
  assert.ok(Math.abs(toy.time - MOST_BEHIND) < 1e-12);
  pace.rest();
  show(20_000);
  assert.ok(Math.abs(toy.time - MOST_BEHIND) < 1e-12);
});

test("a trail goes through what was kept of the last moment", () => {
  const toy = latoLato({ drive: { ...COSINE, amplitude: 0.034 } });
  const motion = new GrowingMotion(toy);
  runOn(toy, 3);
  const poses = motion.recent(3, 0.1);
  assert.equal(poses.length, 14); // every second sample, and now
  const { minute } = toy;
  const row = (name) => minute.recent(name, 0, 0.1, 2);
  poses.slice(0, -1).forEach(({ height, balls: [right, left] }, i) => {
    assert.equal(height, row("pivot_height")[i]);
    assert.ok(Math.abs(right.angle - row("angle")[i]) < 1e-15);
    assert.ok(Math.abs(left.angle + right.angle) < 1e-15);
  });
  assert.equal(poses.at(-1).height, toy.pivot.height);
  assert.equal(motion.end, 3);
});
