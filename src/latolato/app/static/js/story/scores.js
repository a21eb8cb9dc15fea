/** The scores of challenges: less is better. */

import { optionsOf } from "../model/options.js";
import { checkedNumber, InputError } from "../model/rules.js";
import { changeBetween, tongueEdges } from "../model/tongue.js";
import { toSi } from "../model/units.js";
import { withOptions } from "../page/option_texts.js";
import { quantity } from "./numbers.js";
import { t } from "../strings.js";

/** @typedef {import("./contents.js").StoryTable} StoryTable */
/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("../page/block.js").Block} Block */

// Amplitudes are searched up to this many lengths.
const MOST_AMPLITUDE = 1;

/**
 * Return the run that counts for a challenge: its own, with those options that it leaves free.
 * @param {Registry} registry
 * @param {StoryTable} challenge
 * @param {Record<string, string>} options of the player
 * @returns {import("../model/options.js").OptionsRequest}
 */
export function challengeRequest(registry, { look, task }, options) {
  const free = Object.fromEntries(Object.entries(options).filter(([name]) => task.free.includes(name)));
  return { scenario: look.preset, options: withOptions(registry, look.options ?? {}, free) };
}

/**
 * Return the score of a run [SI], NaN if the goal was not reached.
 * @param {Registry} registry
 * @param {StoryTable} task
 * @param {Block} block
 */
export function scoreOfRun(registry, task, block) {
  if (task.rule === "least_amplitude")
    return quantity("top_contacts", block) ? block.about.options.drive_amplitude : NaN;
  return quantity("time_to_angle", block, toSi(registry, "angle", task.angle, "rad"));
}

/**
 * Return how far guessed amplitudes are off on average [m].
 * @param {Registry} registry
 * @param {StoryTable} challenge
 * @param {string} guess such as "30 mm, 12 mm"
 */
export function scoreOfGuess(registry, challenge, guess) {
  const { ratios } = challenge.task;
  const guesses = guess.split(",").map((part) => checkedNumber(
    { ...registry.options.drive_amplitude, limits: [] }, "guess", toSi(registry, "guess", part.trim(), "m")));
  if (guesses.length !== ratios.length)
    throw new InputError(t("refuseGuess", { count: ratios.length, given: guesses.length }));
  const edges = tongueAmplitudes(registry, challenge);
  return guesses.reduce((sum, each, i) => sum + Math.abs(each - edges[i]), 0) / guesses.length;
}

/**
 * Return the least amplitude of parametric resonance at each ratio of a challenge [m].
 * @param {Registry} registry
 * @param {StoryTable} challenge
 * @returns {number[]}
 */
export function tongueAmplitudes(registry, { look, task }) {
  const all = optionsOf(registry, { scenario: look.preset, options: look.options });
  const value = (/** @type {string} */ name) => all[name] ?? registry.options[name].default;
  const [length, gravity] = [value("length"), value("gravity")];
  const zeta = value("damping") / (2 * value("mass") * length * Math.sqrt(gravity / length));
  return task.ratios.map((/** @type {number} */ ratio) => {
    const isCalm = (/** @type {number} */ amplitude) => {
      const [low, high] = tongueEdges((2 * amplitude) / length, zeta);
      return !(low < ratio && ratio < high);
    };
    return changeBetween(isCalm, 0, MOST_AMPLITUDE * length);
  });
}
