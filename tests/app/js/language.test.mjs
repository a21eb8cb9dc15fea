import assert from "node:assert/strict";
import { test } from "node:test";

import { brokenRule, InputError, learnRules, refusal, unknown } from "../../../src/latolato/app/static/js/model/rules.js";
import { inLanguage, inPagesWords, learnKinds, sentenceOfError, warningsText, sentenceInLanguage } from "../../../src/latolato/app/static/js/page/refusals.js";
import { sentence } from "../../../src/latolato/app/static/js/page/link_parts.js";
import { inWords } from "../../../src/latolato/app/static/js/page/option_labels.js";
import { inProse, shownEnd } from "../../../src/latolato/app/static/js/page/unit_text.js";
import { firstOf } from "../../../src/latolato/app/static/js/page/language.js";
import { setLanguage, t, tr } from "../../../src/latolato/app/static/js/strings.js";

const LANGUAGES = { en: { name: "English", beta: false }, id: { name: "Bahasa Indonesia", beta: true } };
const REGISTRY = /** @type {any} */ ({ options: { length: { label: "duljina", unit: "m" } } });
// The sentences of Python.
learnRules(JSON.parse(/** @type {string} */ (process.env.LATOLATO_RULES)));

/** @type {(name: string, rule: string, values: Record<string, number>, wayOut: string) => any} */
const problem = (name, rule, values, wayOut) => ({ name, rule, way_out: wayOut, values: Object.keys(values),
  reported: Object.values(values), parameter: "angle", value: "angle" });

test("of the languages that a reader wants the first that there is is taken, else English", () => {
  assert.equal(firstOf(LANGUAGES, ["id"]), "id");
  assert.equal(firstOf(LANGUAGES, ["de-AT", "id-ID", "en"]), "id");
  assert.equal(firstOf(LANGUAGES, ["en-GB", "id"]), "en");
  assert.equal(firstOf(LANGUAGES, ["", "xx", "constructor"]), "en");
});

test("a refusal has the unit and the label of the screen", () => {
  const limits = [{ is_lower: true, end: 0, is_open: false, rule: "at_least", values: { end: "0" } },
    { is_lower: false, end: Math.PI / 2, is_open: false, rule: "at_most", values: { end: "1.570796327" } }];
  const option = { label: "Where it starts", unit: "rad", units: [{ name: "deg", size: Math.PI / 180 }], limits };
  const registry = /** @type {any} */ ({ options: { angle: option } });
  const beyond = brokenRule("at_most", { parameter: "angle", value: 2 }, { range: "[0, 1.570796327] rad", end: "1.570796327" });
  assert.deepEqual(inPagesWords(registry, beyond),
    ["“Where it starts” must be between 0° and 90°, got 114.592°", "angle"]);
  limits[1].is_open = true;
  assert.equal(inPagesWords(registry, beyond)[0],
    "“Where it starts” must be at least 0° and below 90°, got 114.592°");
  const walls = refusal(problem("angle", "{parameter} must lie between the contact angles [{low:.13g}, {high:.13g}] rad",
    { low: Math.PI / 9, high: Math.PI, angle: Math.PI / 360 }, "give one at which the balls do not overlap"));
  assert.equal(walls.message, "angle must lie between the contact angles [0.3490658503989, 3.14159265359] rad, "
    + "got 0.00872664626; give one at which the balls do not overlap");
  assert.equal(inPagesWords(registry, walls)[0], "“Where it starts” must lie between the contact angles, "
    + "20° and 180°, got 0.5°; give one at which the balls do not overlap");
  const apart = refusal(problem("turn", "the separation {parameter}[0] - {parameter}[1] must lie in [0, 2 pi] rad",
    { angle: -Math.PI / 2 }, ""));
  assert.equal(inPagesWords(registry, apart)[0], "The separation “Where it starts”[0] - “Where it starts”[1] "
    + "must lie between 0° and 360°, got -90°");
  const words = brokenRule("quantity_of_unit", { parameter: "angle", value: "x" }, { unit: "rad" });
  assert.equal(words.message, "angle must be given in rad (or a unit that converts to it), got 'x'");
  assert.equal(inPagesWords(registry, words)[0], "“Where it starts” must be a number in °, got 'x'");
  const endless = brokenRule("number_in_unit", { parameter: "angle", value: -Infinity }, { unit: "rad" });
  assert.equal(inPagesWords(registry, endless)[0], "“Where it starts” must be a number in °, got −∞");
});

test("a rule that is no limit of its option says its own end", () => {
  const limits = [{ is_lower: true, end: 0, is_open: false, rule: "at_least", values: { end: "0" } }];
  const registry = /** @type {any} */ ({ options: {
    low: { label: "Low", unit: "m", units: [{ name: "mm", size: 0.001 }], limits } } });
  const says = (/** @type {InputError} */ error) => inPagesWords(registry, error)[0];
  const values = { range: "(0, inf) m", end: "0" };
  assert.equal(says(brokenRule("more_than", { parameter: "low", value: 0 }, values)),
    "“Low” must be above 0 mm, got 0 mm");
  assert.equal(says(brokenRule("at_least", { parameter: "low", value: -1 }, values)),
    "“Low” must be at least 0 mm, got -1000 mm");
});

test("other numbers have the unit of the screen, and other parameters their labels", () => {
  const low = { label: "Low", unit: "m", units: [{ name: "mm", size: 0.001 }] };
  const registry = /** @type {any} */ ({ options: { low, high: { label: "High", unit: "m" } } });
  const rule = { name: "", part: /** @type {const} */ ("rule"), text: "must be less than {@high}", values: {} };
  assert.equal(inPagesWords(registry, new InputError(rule, { parameter: "low", value: 0.018 }))[0],
    "“Low” must be less than “High”, got 18 mm");
});

test("a field shows its unit, so that a refusal beside it need not", () => {
  const registry = /** @type {any} */ ({ options: { low: { label: "Low", unit: "m" } } });
  for (const [name, text] of Object.entries({ needed: "{law} needs '{@}'{unit}", needed_by_analysis: "this analysis needs {@}{unit}" })) {
    const rule = { name, part: /** @type {const} */ ("rule"), text, values: { law: "Chirp", unit: " [m]" } };
    assert.match(inPagesWords(registry, new InputError(rule, { parameter: "low" }))[0], /needs “Low”$/);
  }
});

test("a value that is repeated has the unit of the screen", () => {
  const low = { label: "Low", unit: "m", units: [{ name: "mm", size: 0.001 }] };
  const rule = { name: "no_repeat", part: /** @type {const} */ ("rule"), text: "must not repeat a value", values: {} };
  assert.equal(inPagesWords(/** @type {any} */ ({ options: { low } }), new InputError(rule, { parameter: "low", value: 0.03 }))[0],
    "“Low” must not repeat a value, got 30 mm");
});

test("ends of intervals are shown as numbers that they hold, and what is no number as such", () => {
  const limits = [{ is_lower: true, end: 0.1001674, is_open: false, rule: "at_least", values: { end: "0.1001674" } },
    { is_lower: false, end: 1, is_open: false, rule: "at_most", values: { end: "1" } }];
  const angle = { label: "Angle", unit: "rad", units: [{ name: "deg", size: Math.PI / 180 }], limits };
  const registry = /** @type {any} */ ({ options: { angle } });
  const says = (/** @type {number} */ value) => inPagesWords(registry, brokenRule("at_most",
    { parameter: "angle", value }, { range: "[0.1001674, 1] rad", end: "1" }))[0];
  // 1 rad is 57.29578 degrees, and the lower end 5.73917.
  assert.equal(says(2), "“Angle” must be between 5.74° and 57.29°, got 114.592°");
  assert.equal(says(Infinity), "“Angle” must be between 5.74° and 57.29°, got ∞");
  const rule = { name: "", part: /** @type {const} */ ("rule"), text: "must be known", values: {} };
  assert.equal(inPagesWords(registry, new InputError(rule, { parameter: "angle", value: NaN }))[0],
    "“Angle” must be known, got no number");
});

test("whole numbers at the ends of intervals are shown as they are", () => {
  assert.equal(shownEnd(65536, false), 65536);
  assert.equal(shownEnd(65536.5, false), 65530);
  const limits = [{ is_lower: false, end: 2 ** 53 - 1, is_open: false, rule: "at_most", values: { end: "9007199254740991" } }];
  const registry = /** @type {any} */ ({ options: { seed: { label: "Seed", unit: "1", limits } } });
  const beyond = brokenRule("at_most", { parameter: "seed", value: 2 ** 60 }, { range: "", end: "9007199254740991" });
  assert.equal(inPagesWords(registry, beyond)[0], "“Seed” must be at most 9007199254740991, got 2⁶⁰");
});

test("a sentence begins with a capital, but names of files and of Python stay as they are", () => {
  const registry = /** @type {any} */ ({ options: {} });
  const says = (/** @type {InputError} */ error) => inPagesWords(registry, error)[0];
  assert.equal(says(new InputError("it holds no columns")), "It holds no columns");
  assert.equal(says(new InputError("it holds no columns", { where: "swing.csv" })), "swing.csv: it holds no columns");
  assert.equal(says(new InputError("must be known", { parameter: "noise_stream" })), "noise_stream must be known");
  const { rule } = brokenRule("axis_needed", {}, { name: "initial_angle" });
  assert.match(says(new InputError(rule)), /^initial_angle is needed/);
  const word = brokenRule("foreign", { parameter: "length" }, { part: { word: "drive" }, owners: "a", kind: "b" });
  assert.match(says(word), /^length belongs to drive a/);
  const needs = brokenRule("needed", { parameter: "length" }, { law: { word: "strings" }, unit: "" });
  assert.equal(says(needs), "Strings needs 'length'");
  assert.equal(sentenceOfError(new InputError("the balls overlap")), "The balls overlap");
  assert.equal(inWords("noise_stream must be known", {}), "noise_stream must be known");
  assert.equal(inWords("the balls overlap", {}), "The balls overlap");
});

test("a sentence says what sets a parameter to a value: in Python's words, or in those of the page", () => {
  const registry = /** @type {any} */ ({ options: {
    suspension: { label: "hung on a", unit: "" }, length: { label: "length", unit: "m" } } });
  const rule = { name: "", part: /** @type {const} */ ("rule"), text: "give {@suspension=rod} or {@damping=0}, {@length=2}", values: {} };
  const error = new InputError(rule);
  assert.equal(error.message, "give suspension='rod' or damping=0, length=2");
  assert.equal(inPagesWords(registry, error)[0], "Give “hung on a” = “rod” or damping=0, “length” = 2");
});

test("names that were given are those of the page, in one pair of quotes", () => {
  const registry = /** @type {any} */ ({ systems: { pendulum: { title: "Pendulum" } }, drives: { push: { title: "Push" } },
    options: { length: { label: "Length", unit: "m" }, mass: { label: "Mass", unit: "kg" } } });
  learnKinds(registry);
  const says = (/** @type {any} */ value) =>
    inPagesWords(registry, new InputError("must differ", { parameter: "drive", value }))[0];
  assert.equal(says("push"), "drive must differ, got “Push”");
  assert.equal(says("Pendulum"), "drive must differ, got “Pendulum”");
  assert.equal(says(["length", "mass"]), "drive must differ, got “Length”, “Mass”");
  assert.equal(says(["abc"]), "drive must differ, got 'abc'");
  // What stands in the field of a number is as somebody typed it.
  const typed = brokenRule("number_in_unit", { parameter: "length", value: ["push", "2"] }, { unit: "m" });
  assert.match(inPagesWords(registry, typed)[0], /, got 'push', '2'$/);
  assert.equal(inWords("did you mean 'drive_speed'?", { drive_speed: { label: "Speed" } }), "Did you mean “Speed”?");
});

test("a quantity in a sentence has the unit of the page", () => {
  const quantity = (/** @type {string} */ unit) =>
    ({ name: "", part: /** @type {const} */ ("rule"), text: "{value:.6g}{unit}", values: { value: Math.PI / 8, unit } });
  const both = { ...quantity(""), text: "{angle} and {rate}", values: { angle: quantity(" rad"), rate: quantity(" rad/s") } };
  assert.equal(sentenceInLanguage(both), "22.5° and 0.392699 rad/s");
  assert.equal(new InputError(both).message, "0.392699 rad and 0.392699 rad/s");
});

test("a label stands in one pair of quotes, and a question ends as one", () => {
  const lacks = brokenRule("needed", { parameter: "length" }, { law: "Chirp", unit: " [m]" });
  assert.equal(sentence(REGISTRY, lacks), "Chirp needs “duljina”.");
  assert.equal(sentence(REGISTRY, new InputError("did you mean 'length'?")), "Did you mean 'length'?");
});

test("each warning ends before the next one begins", () => {
  assert.equal(warningsText(["the ball was hidden", "It stopped."]), "Note: the ball was hidden. Note: It stopped.");
});

test("English has plural forms", () => {
  assert.match(t("mapTrialCount", { count: 1, outside: 0 }), /^1 trial,/);
  assert.match(t("mapTrialCount", { count: 2, outside: 0 }), /^2 trials,/);
});

test("a language has its own plural forms, and data is translated by its English text", () => {
  assert.equal(tr("The first push"), "The first push");
  setLanguage("hr", {
    name: "hrvatski",
    decimal: ",",
    strings: { play: "Pokreni",
      mapTrialCount: { one: "{count} pokus", few: "{count} pokusa", other: "{count} pokusā" } },
    texts: {
      "The first push": "Prvi zamah",
      "length": "duljina",
      "drive": "pogon",
      "got": "zadano je",
    },
    rules: {
      less_than: { rule: "mora biti u {range}", way_out: "zadajte manje od {end}" },
      angle_or_offset: { rule: "zadajte ili {parameter} ili initial_offset" },
      shortest_stage: { rule: "ne smije biti duže od najkraće etape, {shortest} s" },
      unknown: { rule: "{kind} '{name}' nije poznat: {hint}" },
      meant: { rule: "jeste li mislili '{name}'?" },
    },
  });
  assert.equal(t("play"), "Pokreni");
  assert.equal(t("pause"), "Pause", "what is missing is shown in English");
  assert.deepEqual([1, 3, 5].map((count) => t("mapTrialCount", { count })), ["1 pokus", "3 pokusa", "5 pokusā"]);
  assert.equal(tr("The first\npush"), "Prvi zamah", "lines are broken anywhere");
  assert.equal(tr("Length"), "Duljina", "labels begin with a capital on a line of their own");
  assert.equal(tr("toString"), "toString");
});

test("a refusal is translated by the name of its rule, and its English sentence stays", () => {
  const range = { range: "[0, 1) m", end: "1" };
  const error = brokenRule("less_than", { parameter: "radius", value: 1.5 }, range);
  assert.equal(error.message, "radius must lie in [0, 1) m, got 1.5; give less than 1");
  assert.equal(inLanguage(error), "radius mora biti u [0, 1) m, zadano je 1,5; zadajte manje od 1");
  const two = brokenRule("angle_or_offset", { parameter: "length" });
  assert.equal(inPagesWords(REGISTRY, two)[0], "Zadajte ili “duljina” ili initial_offset");
});

test("numbers in a translation have the digits of the English sentence", () => {
  const error = brokenRule("shortest_stage", { parameter: "ramp", value: 2 }, { shortest: 1 / 3 });
  assert.equal(error.message, "ramp must not exceed the shortest stage 0.333333 s, got 2");
  assert.equal(inLanguage(error), "ramp ne smije biti duže od najkraće etape, 0,333333 s, zadano je 2");
});

test("words and sentences in the gaps of a sentence are translated, names are not", () => {
  const error = unknown("drive", "lengt", ["length", "mass"]);
  assert.equal(error.message, "unknown drive 'lengt': did you mean 'length'?");
  assert.equal(inLanguage(error), "pogon 'lengt' nije poznat: jeste li mislili 'length'?");
  assert.match(inLanguage(unknown("drive", "1.5", [])), /^pogon '1\.5' /, "what was typed stays as it is");
});

test("a number that is too small for its unit is refused in the unit of its field", () => {
  const limits = [{ is_lower: true, end: 1e-30, is_open: false, rule: "tiny", values: { end: "1e-30 m" } }];
  const options = { length: { ...REGISTRY.options.length, unit: "m", units: [{ name: "cm", size: 0.01 }], limits } };
  const error = brokenRule("tiny", { parameter: "length", value: 1e-40 }, { end: "1e-30 m" });
  const [text] = inPagesWords({ options }, error);
  assert.match(text, /is too small to compute with.* 10⁻³⁸ cm; check its order of magnitude/);
});

test("beside its field a refusal names no file", () => {
  const error = brokenRule("switch", { parameter: "length", value: 2, where: "swing.mp4" });
  assert.match(inLanguage(error), /^swing\.mp4: length /);
  assert.match(inPagesWords(REGISTRY, error)[0], /^“duljina” /);
});

test("a rule without a translation is in English", () => {
  assert.equal(inLanguage(brokenRule("rigid_rod", { parameter: "string_restitution", value: 0.5 })),
    "string_restitution must be 0 with suspension 'rod', as a rod never goes slack, zadano je 0,5; "
    + "give 0, or suspension='string'");
});

test("numbers in sentences can be read at a glance", () => {
  assert.deepEqual([0, 12, 0.25, 1e300, 1.5e-7, -3.25e40, 2 ** 63, 9007199254740991, Infinity].map((each) => inProse(each)),
    ["0", "12", "0.25", "10³⁰⁰", "1.5 × 10⁻⁷", "−3.25 × 10⁴⁰", "2⁶³", "9007199254740991", "∞"]);
});

test("numbers that a sentence is given are read at a glance too, what somebody typed stays", () => {
  const text = "the run takes {count:g} steps for '{name}'";
  assert.match(sentenceInLanguage({ name: "none", part: "rule", text, values: { count: 1.75e11, name: "1e+09" } }),
    /takes 1[.,]75 × 10¹¹ steps for '1e\+09'/);
});
