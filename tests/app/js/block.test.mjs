// Blocks, as Python packs them; the fixture is written by tests/app/test_javascript.py.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";

import { row, unpack } from "../../../src/latolato/app/static/js/page/block.js";

const bytes = readFileSync(process.env.LATOLATO_BLOCK);
const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);

test("a block holds the header and the arrays that Python packed", () => {
  const block = unpack(buffer);
  assert.equal(block.about.unit, "rad, θ");
  assert.deepEqual([...block.arrays.time], [0, 0.5, 1]);
  assert.deepEqual([...block.arrays.strobe], [0.25, 0.75]);
  assert.deepEqual(block.shapes.angle, [2, 3]);
  assert.deepEqual([...row(block, "angle", 1)], [4, 5, 6]);
  assert.deepEqual([...block.arrays.kind], [0, 255]);
});

test("a block that is cut off is refused", () => {
  assert.throws(() => unpack(buffer.slice(0, 40)));
});
