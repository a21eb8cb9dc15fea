// Texts in the units that people read hold every bit of a number.
import assert from "node:assert/strict";
import test from "node:test";

import { isShown, shownText } from "../../../src/latolato/app/static/js/model/shown.js";

test("numbers are written as people read them", () => {
  assert.equal(shownText(0.02, "mm"), "20");
  assert.equal(shownText(0.0285, "cm"), "2.85");
  assert.equal(shownText(0, "deg"), "0");
  assert.equal(Number(shownText(Math.PI, "deg")), 180);
  assert.equal(Number(shownText(-1e-9, "deg")).toPrecision(12), "-5.72957795131e-8");
  assert.equal(shownText(0.046230794566547356, "cm"), "4.6230794566547356");
  assert.equal(shownText(-5e-7, "mm"), "-0.0005");
  assert.equal(shownText(0.3490658503988659, "deg"), "20");
  for (const angle of [0.1483, -0.35427696829694, 8, 1e-5 / 3])
    assert.match(shownText(angle, "deg").replace(/^-?[0.]*/, "").replace(".", ""), /^\d{1,17}$/);
  assert.ok(isShown("deg") && !isShown("rad/s") && !isShown("constructor"));
});
