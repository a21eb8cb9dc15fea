// What a page draws over maps: JSON of `test_map_over.py` from stdin; numbers that JSON lacks as texts.
import { readFileSync } from "node:fs";

import { InputError, learnRules } from "../../src/latolato/app/static/js/model/rules.js";
import { curveText, parseCurves, placedCurve } from "../../src/latolato/app/static/js/map/overlay_curves.js";
import { linesAt } from "../../src/latolato/app/static/js/map/levels.js";
import { liftOff, Placing, tongue } from "../../src/latolato/app/static/js/map/theory.js";
import { tongueEdges } from "../../src/latolato/app/static/js/model/tongue.js";
import { parseTrials, placedTrials } from "../../src/latolato/app/static/js/map/trials.js";

const { registry, cases } = JSON.parse(readFileSync(0, "utf8"));
learnRules(registry.rules);

const DO = {
  edges: ({ q, zeta }) => tongueEdges(q, zeta),
  lines: ({ values, width, level }) => linesAt(values.map(Number), width, level)
    .map(({ xs, ys }) => [...xs].map((x, i) => [x, ys[i]])),
  tongue: ({ grid }) => tongue(new Placing(grid)),
  lift_off: ({ grid }) => liftOff(new Placing(grid)),
  curves: ({ text, grid }) => parseCurves(text).map((curve) => placedCurve(registry, curve, grid)),
  curve_texts: ({ text, grid }) => parseCurves(text).map((each) => {
    const curve = placedCurve(registry, each, grid);
    return curve.xs.map((_, i) => curveText(registry, { curve: { ...curve, name: "curve" }, i }));
  }),
  trials: ({ text, grid }) => placedTrials(parseTrials(registry, text), new Placing(grid)),
};

function answer({ name, ...given }) {
  try {
    return DO[name](given);
  } catch (error) {
    if (!(error instanceof InputError)) throw error;
    return { error: error.message };
  }
}

process.stdout.write(JSON.stringify(cases.map(answer), (_, value) => {
  if (ArrayBuffer.isView(value)) return Array.from(value);
  return typeof value === "number" && !Number.isFinite(value) ? String(value) : value;
}));
