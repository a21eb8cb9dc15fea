import assert from "node:assert/strict";
import { test } from "node:test";

import { isOwnKey } from "../../../src/latolato/app/static/js/notebook.js";

/** @param {string} key @param {Partial<KeyboardEvent>} [held] */
const press = (key, held = {}) => isOwnKey(
  { key, ctrlKey: false, metaKey: false, altKey: false, shiftKey: false, ...held });

test("keys of the player and letters stay in the player", () => {
  for (const key of [" ", ",", ".", "+", "a", "x", "A", "ArrowLeft", "End", "Enter", "Backspace", "Delete"])
    assert.equal(press(key), true, key);
});

test("shortcuts with modifiers, Shift+Enter, Escape and Tab reach the notebook", () => {
  for (const key of ["Escape", "Tab", "F5", "Shift", "Control"])
    assert.equal(press(key), false, key);
  assert.equal(press("s", { ctrlKey: true }), false);
  assert.equal(press("s", { metaKey: true }), false);
  assert.equal(press("Enter", { shiftKey: true }), false);
  assert.equal(press("Enter", { altKey: true }), false);
});
