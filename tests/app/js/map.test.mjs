// Cells of a map, its colours and its address.
import assert from "node:assert/strict";
import test from "node:test";

import { colourTable } from "../../../src/latolato/app/static/js/map/colours.js";
import { cellAt, Grid } from "../../../src/latolato/app/static/js/map/grid.js";
import { KnownMaps } from "../../../src/latolato/app/static/js/map/known.js";
import { linesOf, roundLevels } from "../../../src/latolato/app/static/js/map/levels.js";
import { misread, spaced, turned } from "../../../src/latolato/app/static/js/map/address.js";
import { Over } from "../../../src/latolato/app/static/js/map/over.js";
import { movedBy, scaledBox } from "../../../src/latolato/app/static/js/map/travel.js";
import { classesOf, wordOf } from "../../../src/latolato/app/static/js/map/class_words.js";
import { readEntry } from "../../../src/latolato/app/static/js/page/entry.js";
import { learnRules } from "../../../src/latolato/app/static/js/model/rules.js";
import { plainSymbol } from "../../../src/latolato/app/static/js/page/unit_text.js";

// The sentences of Python.
learnRules(JSON.parse(/** @type {string} */ (process.env.LATOLATO_RULES)));

const AXIS = { name: "x", label: "x", symbol: "x", unit: "1", log: false, units: [], allowed: [0, null] };

function grid(width, height) {
  const axis = (n) => ({ ...AXIS, values: Float64Array.from({ length: n }, (_, i) => i),
    edges: Float64Array.from({ length: n + 1 }, (_, i) => i - 0.5) });
  return new Grid({ variables: [{ name: "a", ball: null }] }, axis(width), axis(height));
}

function cells(numbers, strides, values) {
  return { cell: Int32Array.from(numbers), stride: Uint8Array.from(strides),
    status: new Uint8Array(numbers.length), values: [Float64Array.from(values)] };
}

test("a value lies in the cell between whose borders it is", () => {
  const edges = [0, 1, 4, 5];
  assert.deepEqual([-0.1, 0, 0.9, 1, 3.9, 5, 5.1].map((v) => cellAt(edges, v)),
    [-1, 0, 0, 1, 1, 2, -1]);
});

test("a coarse point colours its neighbours until they have their own", () => {
  const found = grid(4, 4);
  found.put(cells([0, 2, 8, 10], [2, 2, 2, 2], [1, 2, 3, 4]));
  assert.deepEqual([...found.values[0]], [1, 2, 2, 2, 3, 4, 4, 4, 3, 4, 4, 4, 3, 4, 4, 4]);
  found.put(cells([1, 5], [1, 1], [7, 8]));
  assert.equal(found.values[0][1], 7);
  assert.equal(found.values[0][5], 8);
  assert.equal(found.values[0][6], 4);
  assert.equal(found.isKnown(6), false);
  assert.equal(found.isKnown(5), true);
  // A coarse chunk that comes late changes nothing that is known better.
  found.put(cells([10], [2], [9]));
  assert.equal(found.values[0][5], 8);
  assert.equal(found.values[0][10], 9);
});

test("a map begins with the points that it shares with those before", () => {
  const plan = ({ x, y }, parameters = {}) => ({ x, y, parameters });
  const known = new KnownMaps();
  const old = grid(4, 3);
  old.put(cells([0, 5, 6, 11], [1, 1, 1, 1], [1, 2, 3, 4]));
  known.add(old, plan(old));
  const again = (first, parameters) => {
    const map = grid(4, 3);
    map.x.values = map.x.values.map((value) => value + first);
    known.add(map, plan(map, parameters));
    return [...map.values[0]].filter((_, cell) => map.isKnown(cell));
  };
  assert.deepEqual(again(0), [1, 2, 3, 4]);
  // Moved by one column, up to rounding.
  assert.deepEqual(again(1 + 1e-9), [2, 3, 4]);
  assert.deepEqual(again(0.5), []);
  assert.deepEqual(again(0, { length: 1 }), []);
  // Kicks are those of a cell's number.
  known.add(old, plan(old, { noise_strength: 1 }));
  assert.deepEqual(again(0, { noise_strength: 1 }), [1, 2, 3, 4]);
  assert.deepEqual(again(1, { noise_strength: 1 }), []);
});

test("a map moves by whole cells inside of what is allowed", () => {
  const old = grid(4, 3);
  // Downwards is forbidden: amounts are not negative.
  assert.deepEqual(movedBy(old, 1, -1), [1, 4, 0, 2]);
});

test("along a logarithmic axis a map moves and grows by factors", () => {
  const old = grid(3, 3);
  old.x = { ...AXIS, log: true, values: Float64Array.from([1, 10, 100]),
    edges: Float64Array.from([0.1 ** 0.5, 10 ** 0.5, 1000 ** 0.5, 1e5 ** 0.5]) };
  const near = (found, wanted) => found.forEach((v, i) =>
    assert.ok(Math.abs(v - wanted[i]) < 1e-9 * wanted[i] + 1e-12, `${found}`));
  near(movedBy(old, -2, 0), [0.01, 1, 0, 2]);
  near(scaledBox(old, 1 / 3, [10, 1]), [10 ** 0.5, 1000 ** 0.5, 0.5, 1.5]);
  // Twice as much: zero is never reached.
  assert.ok(scaledBox(old, 8, null)[0] > 0);
});

test("levels are read with their units", () => {
  const registry = { units: { J: [1, { J: 1 }], kg: [1, { kg: 1 }] }, prefixes: { k: 1000, m: 0.001 } };
  const read = (/** @type {string} */ text) => readEntry(text, { registry, unit: "J", usual: { name: "mJ", size: 0.001 },
    isList: true, mayBeEmpty: true });
  assert.deepEqual(read("10, 5;7").values, [0.01, 0.005, 0.007]);
  assert.deepEqual(read("1, 3 J").values, [1, 3]);
  assert.deepEqual(read("1 J, 3").values, [1, 0.003]);
  assert.deepEqual(read("0.5, 1, 2 kJ"), { values: [500, 1000, 2000], text: "0.5 kJ, 1 kJ, 2 kJ", problem: null });
  assert.deepEqual(read(" ").values, []);
  for (const text of ["1,,3", "1, many", "3 kg", "nan"]) assert.notEqual(read(text).problem, null, text);
  assert.equal(read("1, 1e999").problem, "“1e999” is too large to compute with.");
});

test("a number may be followed by the phrase of its field", () => {
  const registry = { units: { Hz: [2 * Math.PI, { s: -1 }] }, prefixes: {} };
  const takes = { registry, unit: "Hz", usual: { name: "Hz", size: 1 }, shown: "per second" };
  const found = readEntry("3 per second", takes);
  assert.deepEqual(found, readEntry("3", takes));
  assert.equal(found.problem, null);
  assert.equal(readEntry("x per second", takes).problem,
    "A number “per second” belongs here; “x per second” is not one.");
});

test("scales are tables of 256 opaque colours from dark to bright", () => {
  for (const name of ["viridis", "cividis", "magma"]) {
    const table = colourTable(name);
    assert.equal(table.length, 256);
    let before = -1;
    for (const pixel of table) {
      assert.equal(pixel >>> 24, 255);
      const [r, g, b] = [pixel & 255, (pixel >> 8) & 255, (pixel >> 16) & 255];
      const light = 0.2126 * r + 0.7152 * g + 0.0722 * b;
      assert.ok(light >= before - 1, `${name} gets darker`);
      before = light;
    }
  }
});

test("symbols become one line of text", () => {
  assert.equal(plainSymbol("A_0"), "A₀");
  assert.equal(plainSymbol("\\omega/\\omega_0"), "ω/ω₀");
  assert.equal(plainSymbol("\\langle E\\rangle"), "⟨E⟩");
  assert.equal(plainSymbol("\\theta_{max}"), "θ_max");
});

test("an axis is changed from what the address says, not from what was on show", () => {
  const shown = { x: { name: "a" }, y: { name: "b" } };
  const extra = { "map.y": "c", "map.ylow": "0.01" };
  assert.deepEqual(spaced(extra, shown, "y", true), { y: "c", ylog: 1 });
  assert.deepEqual(spaced({ "map.ylow": "0" }, shown, "y", true), { y: "b", ylog: 1, ylow: null });
  assert.deepEqual(spaced({ "map.stored": "a.nc" }, shown, "x", false), { xlog: 0 });
  assert.deepEqual(turned(extra, shown, "x", "c"), { x: "c", xlow: "0.01", xhigh: null,
    xlog: null, y: "a", ylow: null, yhigh: null, ylog: null, at: null });
  assert.deepEqual(turned(extra, shown, "x", "d"), { x: "d", xlow: null, xhigh: null, xlog: null, at: null });
});

test("parts of an address that cannot be read are found", () => {
  const registry = { axes: { length: {} }, scenarios: { fig05: { sweep: {} }, toy: {} },
    observables: { mean_energy: { variables: { mean_energy: {} } } } };
  const found = misread(registry, { "map.xlow": "abc", "map.levels": "1,,2", "map.ylog": "yes",
    "map.scale": "rainbow", "map.size": "25", "map.high": "1e3", "map.x": "length", "map.y": "width",
    "play.time": "abc", "map.at_ball": "1", "map.sise": "25", "map.at": "1,2",
    "map.observable": "beauty", "map.scenario": "toy" });
  assert.deepEqual(found, ["map.levels", "map.observable", "map.scale", "map.scenario",
    "map.sise", "map.xlow", "map.y", "map.ylog"]);
  assert.deepEqual(misread(registry, { "map.size": "1" }), ["map.size"]);
});

/** Return a map on which a function of the numbers of column and row has been computed. */
function computed(width, height, field, known = () => true) {
  const map = grid(width, height);
  const all = [...Array(width * height).keys()].filter((at) => known(at % width, Math.floor(at / width)));
  map.put(cells(all, all.map(() => 1), all.map((at) => field(at % width, Math.floor(at / width)))));
  return map;
}

test("contour lines run straight between points, on a logarithmic axis in the logarithm", () => {
  const map = computed(3, 3, (column) => column);
  Object.assign(map.x, { log: true, values: Float64Array.of(1, 100, 10000) });
  const { lines, tiny } = linesOf(map, 0, [0.5, 1.25]);
  assert.equal(tiny, 0);
  assert.deepEqual(lines.map(({ level }) => level), [0.5, 1.25]);
  assert.deepEqual([...lines[0].ys].sort(), [0, 1, 2]);
  for (const [i, wanted] of [10, 100 * 100 ** 0.25].entries())
    for (const x of lines[i].xs) assert.ok(Math.abs(x / wanted - 1) < 1e-12);
});

test("contour lines of a stopped map are those of its complete coarse points", () => {
  const map = computed(41, 41, (column) => column, (column, row) => column !== 3 || row !== 3);
  const { lines } = linesOf(map, 0, [12.3]);
  assert.equal(lines.length, 1);
  assert.equal(lines[0].ys.length, 21);
  assert.ok(lines[0].xs.every((x) => Math.abs(x - 12.3) < 1e-12));
});

test("rings about single points are counted, not drawn, but on small maps", () => {
  const peaks = (column, row) => Number(column % 4 === 2 && row % 4 === 2);
  const large = linesOf(computed(13, 13, peaks), 0, [0.5]);
  assert.deepEqual([large.lines.length, large.tiny], [0, 9]);
  const small = linesOf(computed(6, 6, peaks), 0, [0.5]);
  assert.deepEqual([small.lines.length, small.tiny], [1, 0]);
});

test("a map of a single row has no contour lines", () => {
  assert.deepEqual(linesOf(computed(5, 1, (column) => column), 0, [0.5]), { lines: [], tiny: 0 });
});

test("levels are round in the unit on show", () => {
  const degree = Math.PI / 180;
  assert.deepEqual(roundLevels(0, 3, degree, false).map((level) => Math.round(level / degree)), [50, 100, 150]);
  assert.deepEqual(roundLevels(0.03, 2.9, 1, false), [0.5, 1, 1.5, 2, 2.5]);
  assert.deepEqual(roundLevels(0.003, 700, 1, true), [0.01, 0.1, 1, 10, 100]);
  assert.deepEqual(roundLevels(0.3, 7, 1, true), [0.5, 1, 2, 5]);
  assert.deepEqual(roundLevels(2, 2, 1, false), []);
});

/** Return what is drawn and said of the contour lines that an address names on a map. */
function contoursOn(map, extra, growing = false) {
  const said = {};
  const chart = { contours: [], draw() {} };
  const view = { grid: map, chart, growing: () => growing,
    page: { registry: { options: {}, units: { m: [1, { m: 1 }] }, prefixes: {} }, store: { state: { extra: { "map.contours": "a", ...extra } } } },
    controls: { over: { showContours(variable, text, drawn, isLater, notes) {
      Object.assign(said, { drawn, isLater, notes });
    } } } };
  new Over(view).contours();
  return { ...said, chart };
}

test("contour lines bear their values, those of the address in order and each once", () => {
  const map = computed(4, 4, (column) => column);
  Object.assign(map.variables[0], { units: [{ name: "mm", size: 1e-3 }], classes: [] });
  const { chart, drawn } = contoursOn(map, { "map.levels": "1.5,0.5,1.5" });
  assert.deepEqual(drawn.levels, [0.5, 1.5]);
  assert.deepEqual(chart.contours.map(({ text }) => text), ["500\u00a0mm", "1500\u00a0mm"]);
  const later = contoursOn(map, {}, true);
  assert.deepEqual([later.chart.contours, later.drawn, later.isLater], [[], null, true]);
});

test("an address with too many levels, or with one that is no number, is refused", () => {
  const map = computed(4, 4, (column) => column);
  Object.assign(map.variables[0], { unit: "m", units: [], classes: [] });
  const many = contoursOn(map, { "map.levels": [...Array(21).keys()].join() });
  assert.deepEqual(many.notes, ["At most 20 contour lines, got 21 levels"]);
  const bad = contoursOn(map, { "map.levels": "1,x" });
  assert.deepEqual(bad.notes, ["A level must be a number in SI units, got nan"]);
  assert.deepEqual(bad.chart.contours, []);
});

test("the commonest contact words have classes of their own, as in Python", () => {
  const classes = ["no contact", "R", "B", "BT", "no word", "other words"].map((name) => [name, name]);
  const variable = { classes, words: { codes: [1, 6, 4, 17, 0], further: ["1", "2", "3", "4"] } };
  const values = [4, 16, 64, 256, 5, 16, 64, 21, 17, 0, 1, NaN];
  const of = /** @type {any} */ ({ variables: [variable], values: [values] });
  const found = classesOf(of, 0);
  assert.deepEqual(found.classes.map(([name]) => name), ["no contact", "B", "BT", "no word", "BB",
    "BBB", "T", "TT", "other words"]);
  assert.deepEqual([1, 0, 16, 5, 256].map(found.place), [0, 3, 4, 6, 8]);
  const few = classesOf(/** @type {any} */ ({ variables: [variable], values: [[256, NaN]] }), 0);
  assert.deepEqual(few.classes, [["BBBB", "1"]]);
  const motion = { classes: [["none", ""], ["weak", ""]] };
  const plain = classesOf(/** @type {any} */ ({ variables: [motion], values: [[1]] }), 0);
  assert.deepEqual([plain.classes.length, plain.place(0.9)], [2, 1]);
  const word = (/** @type {number} */ code) => wordOf(/** @type {any} */ (variable), code);
  assert.deepEqual([0, 1, 283, 2 ** 53 - 1].map(word), ["no word", "no contact", "BTRS", "S".repeat(26)]);
});
