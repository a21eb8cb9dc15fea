// The address carries everything; units and symbols as people write them.
import assert from "node:assert/strict";
import test from "node:test";

import { explained } from "../../../src/latolato/app/static/js/analyse/arguments.js";
import { envelope, isDense } from "../../../src/latolato/app/static/js/player/traces.js";
import { Form } from "../../../src/latolato/app/static/js/page/form.js";
import { heldOptions, withOptions } from "../../../src/latolato/app/static/js/page/option_texts.js";
import { format, parse } from "../../../src/latolato/app/static/js/page/state.js";
import { short, symbolParts } from "../../../src/latolato/app/static/js/page/unit_text.js";

test("an address is read back as it was written", () => {
  const state = {
    view: "map", scenario: "fig02", options: { length: "24.5 cm", drive_times: "0 s, 4 s" },
    extra: { "map.x": "frequency_ratio", "map.title": "a&b=c?#ü" },
  };
  assert.deepEqual(parse(format(state)), state);
});

test("numbers are short but exact enough", () => {
  assert.equal(short(0.1 + 0.2), "0.3");
  assert.equal(short(1e-7), "1e-7");
  assert.equal(short(0.00000392), "3.92e-6");
  assert.equal(short(-0.00002), "-2e-5");
  assert.equal(short(0.0002), "0.0002");
  assert.equal(short(100), "100");
  assert.equal(short(123456789, 4), "123500000");
  assert.equal(short(NaN), "");
});

test("symbols in TeX become letters above, on and below the line", () => {
  const shown = (/** @type {string} */ tex) =>
    symbolParts(tex).map(({ text, place }) => (place === "line" ? text : `<${place}>${text}`)).join("");
  assert.equal(shown("\\dot\\theta_0"), "θ\u0307<sub>0");
  assert.equal(shown("t_{end}"), "t<sub>end");
  assert.equal(shown("\\omega^2"), "ω<sup>2");
});

test("the band of a dense, steady swing has straight edges", () => {
  const xs = Float64Array.from({ length: 30000 }, (_, i) => i / 100);
  const ys = xs.map((x) => Math.sin(2 * Math.PI * x * 0.97));
  const position = (/** @type {number} */ x) => 2 * x;
  assert.ok(isDense(1 / 0.97, 2));
  const { low, high } = envelope(xs, ys, 0, xs.length - 1, position, 1 / 0.97);
  assert.equal(low.length, 600);
  for (let i = 1; i < low.length - 1; i += 1) {
    assert.ok(high[i] > 0.99, `column ${i}: ${high[i]}`);
    assert.ok(low[i] < -0.99, `column ${i}: ${low[i]}`);
  }
});

const ALTERNATIVES = [["drive_frequency", "frequency_ratio"], ["initial_angle", "initial_offset"],
  ["samples", "times"], ["duration", "times"]];

test("an option takes the place of what cannot be given beside it, and of nothing else", () => {
  const put = (/** @type {any} */ options, /** @type {any} */ changed) =>
    withOptions({ alternatives: ALTERNATIVES }, options, changed);
  const run = { samples: "100", duration: "9 s" };
  assert.deepEqual(put({ times: "0, 1 s" }, { samples: "100" }), { samples: "100" });
  assert.deepEqual(put({ times: "0, 1 s" }, { duration: "9 s" }), { duration: "9 s" });
  assert.deepEqual(put(run, { samples: "50" }), { samples: "50", duration: "9 s" });
  assert.deepEqual(put({ ...run, mass: "1 kg" }, { times: "0, 1 s" }), { times: "0, 1 s", mass: "1 kg" });
  assert.deepEqual(put({ drive_frequency: "2 Hz" }, { frequency_ratio: "2" }), { frequency_ratio: "2" });
});

test("an empty field takes back what it showed", () => {
  const give = (/** @type {any} */ options, /** @type {any} */ changed) => {
    let after;
    Form.prototype.giveAll.call({ registry: { alternatives: ALTERNATIVES }, store: { state: { options } },
      set: (/** @type {any} */ chosen) => { after = chosen; } }, changed);
    return after;
  };
  const all = { times: "0, 1 s", samples: "100", duration: "9 s" };
  assert.deepEqual(give({ frequency_ratio: "2", mass: "1 kg" }, { drive_frequency: null }), { mass: "1 kg" });
  assert.deepEqual(give(all, { times: null }), { samples: "100", duration: "9 s" });
  assert.deepEqual(give(all, { samples: "50" }), { samples: "50", duration: "9 s" });
});

test("what a run had is kept for another law unless an option says it in another way", () => {
  const registry = { alternatives: ALTERNATIVES, systems: { pendulum: { options: ["mass"] } },
    drives: { harmonic: { options: ["drive_frequency"] } },
    options: Object.fromEntries(["mass", "drive_frequency", "initial_angle", "duration"].map((name) =>
      [name, { unit: "1", units: [] }])) };
  const kinds = { system: "pendulum", drive: "harmonic" };
  const held = (/** @type {any} */ own) =>
    heldOptions(registry, own, { mass: 2, drive_frequency: 10, initial_angle: 0.3, duration: 9 }, kinds, kinds);
  const rest = { mass: "2", drive_frequency: "10" };
  assert.deepEqual(held({ initial_offset: "1" }), { ...rest, duration: "9", initial_offset: "1" });
  assert.deepEqual(held({ times: "0, 1" }), { ...rest, initial_angle: "0.3", times: "0, 1" });
  assert.deepEqual(held({ frequency_ratio: "2" }),
    { mass: "2", initial_angle: "0.3", duration: "9", frequency_ratio: "2" });
});

test("an explanation repeats neither its label nor that of the field above", () => {
  const field = (/** @type {string} */ label, /** @type {string} */ description) => /** @type {any} */ ({ label, description });
  const fields = explained({
    ratio: field("Driving over natural frequency", "driving over natural frequency, ω/ω₀, at least 0.01"),
    low: field("Low", "its lowest and highest value"), high: field("High", "its lowest and highest value"),
    length: field("Length", "length"), angle: field("Angle", "angles of both balls"),
  });
  const shown = Object.values(fields).map(({ isExplained, description }) => (isExplained ? description : null));
  assert.deepEqual(shown, ["ω/ω₀, at least 0.01", "its lowest and highest value", null, null, "angles of both balls"]);
});
