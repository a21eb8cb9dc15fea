/** What a step shows: a state of the page, and the run that belongs to it. */

import { withLaws, withOptions } from "../page/option_texts.js";
import { FIRST } from "../page/state.js";

/** @typedef {import("../page/state.js").State} State */
/** @typedef {import("./contents.js").StoryTable} StoryTable */

// What views keep in the address belongs to the step before.
const OF_VIEWS = ["toy.", "map.", "story."];

/**
 * Return the state that shows a step.
 * @param {State} state on show
 * @param {StoryTable} look
 * @param {Record<string, string>} story what the address keeps of the story
 * @returns {State}
 */
export function shownBy(state, { view, preset, options = {}, extra = {} }, story) {
  const texts = Object.fromEntries(Object.entries(options).map(([name, value]) =>
    [name, Array.isArray(value) ? value.join(", ") : String(value)]));
  const kept = Object.entries(state.extra).filter(([name]) =>
    !OF_VIEWS.some((prefix) => name.startsWith(prefix)));
  return { ...state, view, scenario: preset, options: texts,
    extra: { ...Object.fromEntries(kept), ...extra, ...story } };
}

/**
 * Return the run on show: that of the parameters, on a map that of the point which was chosen, null
 * before one was.
 * @param {any} registry
 * @param {State} state
 * @returns {import("../model/options.js").OptionsRequest | null}
 */
export function runOnShow(registry, { view, scenario, options, extra }) {
  if (!scenario && !options.system) return { scenario: FIRST, options };
  let chosen = options;
  if (scenario && options.system)
    chosen = withLaws(registry, options, {}, options.system, options.drive ?? "fixed_pivot");
  if (view === "map") {
    const [x, y] = (extra["map.at"] ?? "").split(",");
    if (!y || !extra["map.x"] || !extra["map.y"]) return null;
    chosen = withOptions(registry, chosen, { [extra["map.x"]]: x, [extra["map.y"]]: y });
  }
  return { scenario, options: chosen };
}

/**
 * Return the value of a parameter of a run [SI], NaN if it has none.
 * @param {string} name
 * @param {import("../page/block.js").Block} block
 */
export function parameterOf(name, { about: { options, attributes } }) {
  if (name === "frequency_ratio") return options.drive_frequency / attributes.natural_frequency;
  return typeof options[name] === "number" ? options[name] : NaN;
}
