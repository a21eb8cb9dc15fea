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

/** Start a map in two silent workers, and note what comes of it. */
async function started() {
  const workers = [];
  const pool = new Pool(2, () => {
    workers.push(new Silent());
    return workers.at(-1);
  });
  const heard = { cells: [], done: 0, errors: [], restarts: [] };
  const listener = { onCells: ({ cell }) => heard.cells.push(...cell), onDone: () => (heard.done += 1),
    onError: ({ message }) => heard.errors.push(message),
    onRestart: (message) => heard.restarts.push(message) };
  await pool.start(PLAN, listener);
  return { pool, workers, heard, listener };
}

test("cells come from coarse to fine, every one once", () => {
  const { cells, strides } = inOrder(50, 30);
  assert.deepEqual([...new Set(strides)], [4, 2, 1]);
  assert.deepEqual([...cells].sort((a, b) => a - b), Array.from({ length: 1500 }, (_, i) => i));
  const coarse = [...cells].filter((_, i) => strides[i] === 4);
  assert.equal(coarse.length, 13 * 8);
  assert.ok(coarse.every((cell) => cell % 50 % 4 === 0 && Math.floor(cell / 50) % 4 === 0));
  assert.deepEqual([...inOrder(3, 2).strides], [1, 1, 1, 1, 1, 1]);
});

test("a map with a stride has every so many rows and columns, and goes on with the others", async () => {
  const { pool, workers, heard, listener } = await started();
  await pool.start(PLAN, listener, undefined, 2);
  while (!heard.done) for (const worker of workers.filter(({ ended, cells }) => !ended && cells.length)) worker.answer();
  assert.equal(heard.cells.length, 15 * 10);
  assert.ok(heard.cells.every((cell) => cell % 30 % 2 === 0 && Math.floor(cell / 30) % 2 === 0));
  heard.cells.length = 0;
  await pool.start(PLAN, listener);
  assert.equal(heard.cells.length, 15 * 10);
  while (heard.done < 2) for (const worker of workers.filter(({ ended, cells }) => !ended && cells.length)) worker.answer();
  assert.deepEqual(heard.cells.sort((a, b) => a - b), Array.from({ length: 600 }, (_, i) => i));
});

test("workers share the first picture, and all cells come", async () => {
  const { workers, heard } = await started();
  assert.deepEqual(workers.map(({ cells }) => cells[0].length), [75, 75]);
  while (!heard.done) for (const worker of workers) if (worker.cells.length) worker.answer();
  assert.deepEqual(heard.cells.sort((a, b) => a - b), Array.from({ length: 600 }, (_, i) => i));
  assert.equal(heard.done, 1);
});

test("a new map ends the workers that are busy, and what they say is not heard", async () => {
  const { pool, workers, heard, listener } = await started();
  await pool.start({ ...PLAN, duration: 200 }, listener);
  assert.deepEqual(workers.map(({ ended }) => ended), [true, true, false, false]);
  assert.deepEqual(workers.slice(2).map(({ plan }) => plan.duration), [200, 200]);
  workers[0].answer();
  assert.deepEqual(heard.cells, []);
  pool.stop();
  assert.ok(workers.every(({ ended }) => ended));
});

test("what was computed before comes at once", async () => {
  const { pool, workers, heard, listener } = await started();
  const { cells: [first] } = workers[0];
  workers[0].answer();
  heard.cells = [];
  await pool.start(PLAN, listener);
  assert.deepEqual(heard.cells, [...first]);
  while (!heard.done) for (const each of workers) if (!each.ended && each.cells.length) each.answer();
  assert.deepEqual(heard.cells.sort((a, b) => a - b), Array.from({ length: 600 }, (_, i) => i));
  // Moved by ten columns: twenty are the same.
  const x = { ...PLAN.x, values: PLAN.x.values.map((value) => value + 2) };
  heard.cells = [];
  await pool.start({ ...PLAN, x }, listener);
  assert.deepEqual(heard.cells.sort((a, b) => a - b),
    Array.from({ length: 600 }, (_, i) => i).filter((i) => i % 30 < 20));
  heard.cells = [];
  await pool.start({ ...PLAN, duration: 100 }, listener);
  assert.deepEqual(heard.cells, []);
});

test("a worker that dies is replaced, says so, and its cells are computed again", async () => {
  const { workers, heard } = await started();
  const [lost] = workers[0].cells;
  workers[0].say("error", { message: "out of memory" });
  assert.deepEqual(heard.restarts, ["out of memory"]);
  assert.equal(workers.length, 3);
  assert.ok(workers[0].ended);
  assert.deepEqual(workers[2].cells, [lost]);
  workers[2].say("message", { data: { death: "unreachable" } });
  assert.deepEqual(heard.errors, ["some points of this map cannot be computed: unreachable"]);
  assert.ok(workers.every(({ ended }) => ended));
});

test("what is wrong with a map is told once", async () => {
  const { pool, workers, heard, listener } = await started();
  for (const worker of workers) worker.say("message", { data: { error: "no drive is called hand" } });
  assert.deepEqual(heard.errors, ["no drive is called hand"]);
  const wrong = { ...PLAN, parameters: { ...PLAN.parameters, colour: 1 } };
  await pool.start(wrong, listener);
  await pool.start({ ...PLAN, parameters: { ...PLAN.parameters, radius: 2 } }, listener);
  assert.deepEqual(heard.errors.slice(1),
    ["no map has the parameter colour", "no point of this map can run"]);
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
  assert.ok(one.in_lanes && one.seconds > 0);
  assert.ok(Math.abs(longer.steps / one.steps - 2) < 1e-9);
});
