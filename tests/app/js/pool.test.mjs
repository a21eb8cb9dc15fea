// Maps from coarse to fine in a pool of workers, here without any that compute.
import assert from "node:assert/strict";
import test from "node:test";

import { inOrder } from "../../../src/latolato/app/static/js/map/plan.js";
import { Pool } from "../../../src/latolato/app/static/js/map/pool.js";

const PLAN = { drive: "harmonic", duration: 300, observables: [{ name: "crossings" }],
  parameters: { gravity: 9.8, length: 1, mass: 0.8, radius: 0.1, restitution: 1, collides: 1,
    tolerance: 1e-6, rest_speed: 1e-6, initial_angle: 0.4 },
  x: { name: "drive_frequency", values: Array.from({ length: 30 }, (_, i) => 1 + 0.2 * i) },
  y: { name: "drive_amplitude", values: Array.from({ length: 20 }, (_, i) => 0.01 * i) } };

/** A worker that notes what it is sent; `answer` and `die` are called by tests. */
class Silent extends EventTarget {
  constructor() {
    super();
    this.cells = [];
    this.ended = false;
  }

  postMessage(data) {
    if (data.cells) this.cells.push(data.cells);
    if (data.plan) this.plan = data.plan;
  }

  terminate() {
    this.ended = true;
  }

  say(name, values) {
    this.dispatchEvent(Object.assign(new Event(name), values));
  }

  answer() {
    const { length } = this.cells.at(-1);
    this.say("message", { data: { status: new Uint8Array(length), seconds: 0.01,
      values: [new Float64Array(length)] } });
  }
}

/** Start a map in two silent workers; `heard` is what comes of it, and `start` starts another one. */
async function started(plan = PLAN, how = {}) {
  const workers = [];
  const pool = new Pool(2, () => {
    workers.push(new Silent());
    return workers.at(-1);
  });
  const heard = { cells: [], done: 0, errors: [] };
  const start = async (plan, how = {}) => {
    void pool.compute(plan, await pool.estimate(plan), { ...how,
      onCells: ({ cell }) => heard.cells.push(...cell),
    }).then(() => { heard.done += 1; }, ({ name, message }) => heard.errors.push(message || name));
    await settled();
  };
  await start(plan, how);
  /** Let workers answer until the map is complete. */
  const finish = () => {
    while (pool.job) for (const worker of workers) if (!worker.ended && worker.cells.length) worker.answer();
    return settled();
  };
  return { pool, workers, heard, start, finish };
}

/** Wait for what is ready. */
const settled = () => new Promise((resolve) => { setTimeout(resolve); });
const ALL = Array.from({ length: 600 }, (_, i) => i);
const sorted = (cells) => [...cells].sort((a, b) => a - b);

test("cells come from coarse to fine, every one once", () => {
  const { cells, strides } = inOrder(50, 30);
  assert.deepEqual([...new Set(strides)], [4, 2, 1]);
  assert.deepEqual([...cells].sort((a, b) => a - b), Array.from({ length: 1500 }, (_, i) => i));
  const coarse = [...cells].filter((_, i) => strides[i] === 4);
  assert.equal(coarse.length, 13 * 8);
  assert.ok(coarse.every((cell) => cell % 50 % 4 === 0 && Math.floor(cell / 50) % 4 === 0));
  assert.deepEqual([...inOrder(3, 2).strides], [1, 1, 1, 1, 1, 1]);
});

test("a map with a stride has every so many rows and columns, known ones are not computed", async () => {
  const { heard, start, finish } = await started(PLAN, { stride: 2 });
  await finish();
  assert.equal(heard.cells.length, 15 * 10);
  assert.ok(heard.cells.every((cell) => cell % 30 % 2 === 0 && Math.floor(cell / 30) % 2 === 0));
  const known = new Set(heard.cells);
  await start(PLAN, { isKnown: (cell) => known.has(cell) });
  await finish();
  assert.deepEqual(sorted(heard.cells), ALL);
  await start(PLAN, { isKnown: () => true });
  assert.deepEqual([heard.cells.length, heard.done], [600, 3]);
});

test("workers share the first picture, and all cells come", async () => {
  const { workers, heard, finish } = await started();
  assert.deepEqual(workers.map(({ cells }) => cells[0].length), [75, 75]);
  await finish();
  assert.deepEqual(sorted(heard.cells), ALL);
  assert.equal(heard.done, 1);
});

test("a new map ends the workers that are busy, and what they say is not heard", async () => {
  const { pool, workers, heard, start } = await started();
  await start({ ...PLAN, duration: 200 });
  assert.deepEqual(workers.map(({ ended }) => ended), [true, true, false, false]);
  assert.deepEqual(workers.slice(2).map(({ plan }) => plan.duration), [200, 200]);
  workers[0].answer();
  assert.deepEqual([heard.cells, heard.errors], [[], ["AbortError"]]);
  pool.stop();
  assert.ok(workers.every(({ ended }) => ended));
});

for (const [name, values] of [["error", { message: "unreachable" }], ["message", { data: { death: "unreachable" } }]])
  test(`a worker that dies ends its map, and the next map has another one: ${name}`, async () => {
    const { workers, heard, start, finish } = await started();
    workers[0].say(name, values);
    await settled();
    assert.deepEqual(heard.errors, ["some points of this map cannot be computed: unreachable"]);
    assert.ok(workers.every(({ ended }) => ended));
    await start(PLAN);
    await finish();
    assert.deepEqual(sorted(heard.cells), ALL);
  });

test("what is wrong with a map is told once", async () => {
  const { pool, workers, heard } = await started();
  for (const worker of workers) worker.say("message", { data: { error: "no drive is called hand" } });
  await settled();
  assert.deepEqual(heard.errors, ["no drive is called hand"]);
  await assert.rejects(pool.estimate({ ...PLAN, parameters: { ...PLAN.parameters, colour: 1 } }),
    { message: "no map has the parameter colour" });
  const { problem } = await pool.estimate({ ...PLAN, parameters: { ...PLAN.parameters, radius: 2 } });
  assert.equal(problem.parameter, "radius");
});

test("a small batch, which leaves lanes empty, does not change what is known of the speed", async () => {
  const { pool, workers } = await started();
  const before = pool.step.lanes;
  assert.ok(workers[0].cells[0].length < 256);
  workers[0].answer();
  assert.equal(pool.step.lanes, before);
  assert.ok(workers[0].cells[1].length >= 150);
  workers[1].answer();
  workers[1].answer();
  assert.equal(pool.step.lanes === before, workers[1].cells[1].length < 256);
});

test("an estimate grows with the map", async () => {
  const pool = new Pool(2, () => new Silent());
  const one = await pool.estimate(PLAN);
  const longer = await pool.estimate({ ...PLAN, duration: 600 });
  assert.ok(one.in_lanes && one.longest > 0);
  assert.ok(Math.abs(longer.steps / one.steps - 2) < 1e-9);
});
