// Limits and round numbers of axes, of whatever values there are.
import assert from "node:assert/strict";
import test from "node:test";

import { axisLimits, logTicks, SINGLE, ticks } from "../../../src/latolato/app/static/js/player/axis.js";
import { Grid } from "../../../src/latolato/app/static/js/map/grid.js";
import { lookOf } from "../../../src/latolato/app/static/js/map/colours.js";
import { range } from "../../../src/latolato/app/static/js/player/motion.js";

// Sizes from next to nothing to almost too much, of both signs.
const SIZES = [0, 5e-324, 1e-300, 1e-12, 0.1, 5.739170610488057, 1, 1e9, 1e300, Number.MAX_VALUE]
  .flatMap((size) => [size, -size]);
const ODD = [NaN, Infinity, -Infinity, null, undefined];
// From nothing at all over rounding to what is plainly different.
const SHARES = [0, 2 ** -53, 2 ** -52, 1e-15, 1e-12, 1e-10, 1.1e-9, 1e-6, 0.5, 2, 1e12];

test("limits are finite, rise, and hold what they are of", () => {
  const all = [...SIZES, ...ODD];
  for (const low of all)
    for (const high of [...all, ...SHARES.map((share) => low + share * Math.abs(low))]) {
      const [from, to] = axisLimits(low, high);
      assert.ok(Number.isFinite(from) && Number.isFinite(to), `${low} to ${high}`);
      assert.ok(to - from > 1e-9 * Math.max(Math.abs(from), Math.abs(to)), `${low} to ${high}`);
      for (const end of [low, high])
        if (Number.isFinite(end) && Math.abs(end) <= 1e300)
          assert.ok(from <= end && end <= to, `${end} in ${from} to ${to}`);
    }
});

test("limits that can be drawn stay as they are", () => {
  assert.deepEqual(axisLimits(1, 1 + 1e-8), [1, 1 + 1e-8]);
  assert.deepEqual(axisLimits(0, 1e-30), [0, 1e-30]);
  assert.deepEqual(axisLimits(-3, 7), [-3, 7]);
});

test("samples in single precision that differ in the last place are one value", () => {
  const next = Math.fround(5.739) + 2 ** -21;
  const [from, to] = axisLimits(Math.fround(5.739), next, SINGLE);
  assert.ok(to - from > 0.1);
});

test("round numbers end soon, rise, and lie within the limits", () => {
  for (const low of SIZES)
    for (const share of SHARES)
      for (const count of [2, 5, 40]) {
        const high = low + share * Math.abs(low);
        const found = ticks(low, high, count);
        assert.ok(found.length <= 20 * count, `${low} to ${high}: ${found.length}`);
        assert.ok(found.every(Number.isFinite), `${low} to ${high}`);
        assert.ok(found.every((mark, i) => i === 0 || mark > found[i - 1]), `${low} to ${high}`);
      }
  for (const odd of ODD) for (const other of [odd, 0, 1]) {
    assert.ok(ticks(odd, other).length <= 1);
    assert.ok(ticks(other, odd).length <= 1);
  }
});

test("a logarithmic axis numbers powers of ten, their doubles and halves where they are few", () => {
  assert.deepEqual(logTicks(0.01, 1, 6).marks, [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1]);
  assert.deepEqual(logTicks(3e-4, 2, 6).marks, [0.001, 0.01, 0.1, 1]);
  assert.deepEqual(logTicks(1e-12, 1, 6).marks, [1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 0.01, 1]);
  // The ends count where a change of unit has rounded them.
  assert.deepEqual(logTicks(0.01 * (1 + 1e-15), 1 - 1e-15, 6).marks.length, 7);
});

test("a logarithmic axis has small marks up to four decades, and round numbers within one", () => {
  const { small } = logTicks(0.5, 30, 6);
  assert.deepEqual(small.map((mark) => Number(mark.toPrecision(6))),
    [0.5, 0.6, 0.7, 0.8, 0.9, ...Array.from({ length: 10 }, (_, k) => k + 1), 20, 30]);
  assert.deepEqual(logTicks(1e-6, 1, 6).small, []);
  for (const [low, high] of [[6, 9], [0, 1], [-2, 3]])
    assert.deepEqual(logTicks(low, high, 4), { marks: ticks(low, high, 4), small: [] });
});

test("the same angle with two roundings has one mark", () => {
  assert.deepEqual(ticks(1, 1), [1]);
  assert.deepEqual(ticks(5.739170610488055, 5.739170610488058), [5.739170610488055]);
});

test("a wide range has round marks", () => {
  assert.deepEqual(ticks(0, 10), [0, 2, 4, 6, 8, 10]);
  assert.deepEqual(ticks(-0.1, 0.1, 4).map((x) => Number(x.toFixed(3))),
    [-0.1, -0.05, 0, 0.05, 0.1]);
});

test("a range leaves out what is not finite", () => {
  assert.deepEqual(range([Infinity, 1, NaN, 2, -Infinity]), [1, 2]);
});

/** A map of two by two cells with these values. */
function mapOf(values) {
  const axis = { name: "x", values: [0, 1], edges: [-0.5, 0.5, 1.5] };
  const found = new Grid({ variables: [{ name: "a", ball: null, classes: [] }], observable: "a" }, axis, axis);
  found.values[0].set(values);
  return found;
}

test("the colours of a map have limits, whatever its values are", () => {
  const rounded = [0.1, 0.1 + 2 ** -27, 0.1, 0.1];
  for (const values of [[2, 2, 2, 2], rounded, [Infinity, 1, 2, NaN], [NaN, NaN, NaN, NaN],
    [0, -1, 0, 0]])
    for (const log of ["0", "1"]) {
      const { limits: [low, high] } = lookOf(mapOf(values), { "map.log": log });
      assert.ok(Number.isFinite(high - low) && high - low > 1e-6 * Math.abs(high), `${values}`);
      assert.ok(log === "0" || low > 0, `${values}`);
    }
  const { limits: [low, high] } = lookOf(mapOf([0, 1, 2, 3]),
    { "map.low": "1", "map.high": String(1 + 2 ** -52) });
  assert.ok(high - low > 0.01);
});
