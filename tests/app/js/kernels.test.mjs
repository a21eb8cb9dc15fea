// Memory of compiled code: arrays, records, words and tables, without any compiled code.
import assert from "node:assert/strict";
import test from "node:test";

import { Kernels } from "../../../src/latolato/app/static/js/kernels/memory.js";

const LAYOUT = {
  records: {
    state: { size: 24, fields: { steps: { at: 0, type: "i8", shape: [] },
      angle: { at: 8, type: "f8", shape: [2] } } },
    run: { size: 56, fields: { t: { at: 0, type: "f8", shape: [] },
      state: { at: 8, type: "state", shape: [] } } },
  },
  bundles: { task: [{ name: "order", type: "i8", dimensions: 1 },
    { name: "points.stops", type: "f8", dimensions: 2 }, { name: "gravity", type: "f8" },
    { name: "limit", type: "i8" }] },
  modules: { small: ["engine", "angles.step"] }, rows: { upright: {}, plane: {} },
};
const PLACES = [3, 8];

/** A module whose kernels stand at places 3 and 8, whose `engine` notes the words it is given. */
function small() {
  const memory = new WebAssembly.Memory({ initial: 1 });
  new Uint32Array(memory.buffer, 16, PLACES.length).set(PLACES);
  const called = [];
  const engine = (at) => called.push([...new BigInt64Array(memory.buffer, at, 10)]);
  const exports = { memory, kernels: { value: 16 }, __heap_base: { value: 100 }, engine };
  return { kernels: new Kernels(exports, LAYOUT, "small"), called };
}

test("arrays lie one behind the other, aligned and zero, also where others lay before", () => {
  const { kernels } = small();
  const first = kernels.take("f8", 2, 3);
  assert.deepEqual(first, { at: 128, type: "f8", shape: [2, 3] });
  kernels.numbers(first).fill(7);
  assert.equal(kernels.take("i8", 1).at, 192);
  kernels.release(first);
  assert.deepEqual([...kernels.numbers(kernels.take("f8", 6))], [0, 0, 0, 0, 0, 0]);
});

test("memory grows as far as an array needs, and keeps what was in it", () => {
  const { kernels } = small();
  const first = kernels.take("f8", 1);
  kernels.numbers(first)[0] = 1.5;
  const large = kernels.take("run", 5000);
  assert.equal(kernels.bytes(large).length, 280_000);
  assert.equal(kernels.numbers(first)[0], 1.5);
  assert.ok(kernels.exports.memory.buffer.byteLength - kernels.top < 65536);
});

test("fields of records are found by their path, also of later records", () => {
  const { kernels } = small();
  const runs = kernels.take("run", 2);
  kernels.set(runs, "state.steps", 12);
  kernels.set(runs, "state.angle", 0.5, -0.25);
  assert.equal(kernels.get(runs, "state.steps"), 12);
  assert.deepEqual([...kernels.numbers(kernels.field(runs, "state.angle"))], [0.5, -0.25]);
  assert.equal(kernels.get(runs, "state.angle.1"), -0.25);
  assert.equal(kernels.get(runs, "state.steps", 1), 0);
  assert.equal(kernels.field(runs, "state.angle", 1).at, runs.at + 56 + 16);
  assert.throws(() => kernels.get(runs, "state.colour"), /state has no field colour/);
});

test("a kernel is called with the words of its arguments, in the order of the layout", () => {
  const { kernels, called } = small();
  const order = kernels.take("i8", 4);
  const stops = kernels.take("f8", 4, 3);
  const before = kernels.top;
  const given = { order, "points.stops": stops, gravity: 9.8, limit: 1e6 };
  kernels.call("engine", "task", given);
  const [gravity] = new BigInt64Array(new Float64Array([9.8]).buffer);
  assert.deepEqual(called, [[BigInt(order.at), 4n, 8n, BigInt(stops.at), 4n, 3n, 24n, 8n, gravity,
    1000000n]]);
  assert.ok(kernels.top - before < 64); // the words are given back
  for (const wrong of [{ order: stops }, { "points.stops": order }, { limit: undefined },
    { gravity: order }, { order: undefined }]) {
    assert.throws(() => kernels.call("engine", "task", { ...given, ...wrong }), TypeError);
  }
});

test("the table of callbacks names kernels by their places", () => {
  const { kernels } = small();
  const table = kernels.callbacks([[], [[4, "angles.step"], [0, "engine"]], []]);
  assert.deepEqual([...kernels.numbers(table)].map(Number), [3, 4, 9, 0, 8, 4, 3, 0, 0, 0]);
  assert.throws(() => kernels.callbacks([[[0, "energy.step"]]]), /no kernel energy.step/);
});
