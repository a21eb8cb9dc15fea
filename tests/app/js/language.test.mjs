import assert from "node:assert/strict";
import { test } from "node:test";

import { InputError } from "../../../src/latolato/app/static/js/model/rules.js";
import { inPagesWords } from "../../../src/latolato/app/static/js/shared/refusals.js";
import { sentence } from "../../../src/latolato/app/static/js/shared/reading.js";
import { firstOf } from "../../../src/latolato/app/static/js/shared/language.js";
import { setLanguage, t, tr } from "../../../src/latolato/app/static/js/strings.js";

const LANGUAGES = { en: { name: "English", beta: false }, id: { name: "Bahasa Indonesia", beta: true } };
const REGISTRY = /** @type {any} */ ({ options: { length: { label: "duljina", unit: "m" } } });

test("of the languages that a reader wants the first that there is is taken, else English", () => {
  assert.equal(firstOf(LANGUAGES, ["id"]), "id");
  assert.equal(firstOf(LANGUAGES, ["de-AT", "id-ID", "en"]), "id");
  assert.equal(firstOf(LANGUAGES, ["en-GB", "id"]), "en");
  assert.equal(firstOf(LANGUAGES, ["", "xx", "constructor"]), "en");
});

test("a refusal has the unit and the label of the screen", () => {
  const option = { label: "Where it starts", unit: "rad", units: [{ name: "deg", size: Math.PI / 180 }] };
  const registry = /** @type {any} */ ({ options: { angle: option } });
  const beyond = new InputError("must lie in [0, 1.570796327] rad", { parameter: "angle", value: 2,
    wayOut: "give at most 1.570796327" });
  assert.deepEqual(inPagesWords(registry, beyond),
    ["“Where it starts” must lie between 0 and 90°, got 114.592", "angle"]);
  const walls = new InputError("{parameter} must lie between the contact angles [0.3490658504, pi] rad",
    { parameter: "angle", value: Math.PI / 360, wayOut: "give one at which the balls do not overlap" });
  assert.equal(inPagesWords(registry, walls)[0], "“Where it starts” must lie between the contact angles, "
    + "20 and 180°, got 0.5; give one at which the balls do not overlap");
  const apart = new InputError("the separation {parameter}[0] - {parameter}[1] must lie in [0, 2 pi] rad",
    { parameter: "angle", value: -Math.PI / 2 });
  assert.equal(inPagesWords(registry, apart)[0], "the separation “Where it starts”[0] - “Where it starts”[1] "
    + "must lie between 0 and 360°, got -90");
  const words = new InputError("must be given in rad (or a unit)", { parameter: "angle", value: "x" });
  assert.equal(inPagesWords(registry, words)[0], "“Where it starts” must be a number in °, got 'x'");
});

test("a label stands in one pair of quotes, and a question ends as one", () => {
  const lacks = new InputError("Chirp needs '{parameter}' [m]", { parameter: "length" });
  assert.equal(sentence(REGISTRY, lacks), "Chirp needs “duljina” [m].");
  assert.equal(sentence(REGISTRY, new InputError("did you mean 'length'?")), "Did you mean 'length'?");
});

test("English has plural forms", () => {
  assert.match(t("mapTrialCount", { count: 1, outside: 0 }), /^1 trial,/);
  assert.match(t("mapTrialCount", { count: 2, outside: 0 }), /^2 trials,/);
});

test("a language has its own plural forms, and data is translated by its English text", () => {
  assert.equal(tr("The first push"), "The first push");
  setLanguage("hr", {
    name: "hrvatski",
    strings: { play: "Pokreni",
      mapTrialCount: { one: "{count} pokus", few: "{count} pokusa", other: "{count} pokusā" } },
    texts: {
      "The first push": "Prvi zamah",
      "right ball": "desna kugla",
      "{name}, right ball": "{name}, desna kugla",
      "length": "duljina",
      "must be {kind}": "mora biti {kind}",
      "{one} and {other}": "{one} i {other}",
      "at least {value}": "barem {value}",
      "below {value}": "ispod {value}",
      "the length": "duljine",
      "give less than {value}": "zadajte manje od {value}",
      "give only one of {parameter} and {other}": "zadajte ili {parameter} ili {other}",
      "got": "zadano je",
    },
  });
  assert.equal(t("play"), "Pokreni");
  assert.equal(t("pause"), "Pause", "what is missing is shown in English");
  assert.deepEqual([1, 3, 5].map((count) => t("mapTrialCount", { count })), ["1 pokus", "3 pokusa", "5 pokusā"]);
  assert.equal(tr("The first\npush"), "Prvi zamah", "lines are broken anywhere");
  assert.equal(tr("Length"), "Duljina", "labels begin with a capital on a line of their own");
  assert.equal(tr("length, right ball"), "duljina, desna kugla");
  assert.equal(tr("toString"), "toString");
});

test("a refusal is translated in its parts, and its English sentence stays", () => {
  const error = new InputError("must lie in [0, length)",
    { parameter: "length", value: 0.5, wayOut: "give less than 0.4" });
  assert.equal(error.message, "length must lie in [0, length), got 0.5; give less than 0.4");
  assert.deepEqual(inPagesWords(REGISTRY, error),
    ["“duljina” mora biti barem 0 m i ispod duljine, zadano je 0,5; zadajte manje od 0,4", "length"]);
  const two = new InputError("give only one of {parameter} and initial_offset", { parameter: "length" });
  assert.equal(inPagesWords(REGISTRY, two)[0], "zadajte ili “duljina” ili initial_offset");
});
