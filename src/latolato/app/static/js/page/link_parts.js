/** Which parts of a link there are: the others are left out, and named on the stage. */

import { InputError } from "../model/rules.js";
import { t } from "../strings.js";
import { textOf, withLaws } from "./option_texts.js";
import { inPagesWords, stopped } from "./refusals.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Page} Page */
/** @typedef {import("../model/registry.js").Registry} Registry */

// Longer texts of a link are not repeated.
const LONGEST = 60;
// What a link may hold of views that read all of theirs; others name what they cannot read themselves.
const PARTS = /** @type {Record<string, string[]>} */ ({
  toy: ["hand", "kept"], report: [],
  story: ["list", "name", "step", "answers", "tried", "guess"],
});
// What is pressed where an option is missing, or is none of the system, the drive and the contact.
const MENDED = /** @type {Record<string, string>} */ ({ needed: "takeUsual", angle_needed: "takeUsual",
  duration_needed: "takeUsual", foreign: "leaveItOut", foreign_part: "leaveItOut" });
// Views that show one run; a sweep opens in Map.
const OF_RUNS = ["toy", "analyse"];

/**
 * Return the state that remains of a link without parts that are unknown here, and the names and texts of
 * those. What a view keeps in the address is read by that view.
 * @param {Registry} registry
 * @param {State} state
 * @param {string[]} views
 * @returns {{state: State, left: [string, string][]}}
 */
export function readable(registry, state, views) {
  /** @type {[string, string][]} */
  const left = [];
  let { view } = state;
  let scenario = state.scenario || null;
  if (!views.includes(view)) {
    left.push(["view", view]);
    view = "toy";
  }
  const preset = scenario && Object.hasOwn(registry.scenarios, scenario) ? registry.scenarios[scenario] : null;
  if (scenario && !preset) {
    left.push(["scenario", scenario]);
    scenario = null;
  }
  if (preset?.sweep && OF_RUNS.includes(view)) view = "map";
  const options = Object.fromEntries(Object.entries(state.options).filter(([name, text]) => {
    const isOne = isKnown(registry, name, text);
    if (!isOne) left.push([name, text]);
    return isOne;
  }));
  const extra = Object.fromEntries(Object.entries(state.extra).filter(([name, text]) => {
    const [owner, ...part] = name.split(".");
    const isOne = Object.hasOwn(PARTS, owner) ? PARTS[owner].includes(part.join(".")) : views.includes(owner);
    if (!isOne) left.push([name, text]);
    return isOne;
  }));
  return { state: { ...state, view, scenario, options, extra }, left };
}

/**
 * Return whether there is such an option, of a law whether there is that law. Whether it goes with the others
 * and its value is allowed is for the run to say.
 * @param {Registry} registry
 * @param {string} name
 * @param {string} text
 */
function isKnown({ options, systems, drives }, name, text) {
  const laws = { system: systems, drive: drives }[name];
  return Object.hasOwn(options, name) && (!laws || Object.hasOwn(laws, text));
}

/**
 * Return an error as a sentence of the page.
 * @param {Registry} registry
 * @param {Error} error
 */
export function sentence(registry, error) {
  return stopped(inPagesWords(registry, error)[0]);
}

/**
 * The ways back from a refused run, and out of one whose options do not go with its system and drive.
 * @param {Page} page
 * @param {Error | null} error why it was refused, null if it was stopped
 * @returns {import("./messages.js").MessageAction[]}
 */
export function waysBack({ registry, store }, error) {
  const { scenario, options } = store.state;
  const hasPreset = (scenario !== null || !options.system) && Object.keys(options).length > 0;
  const rule = error instanceof InputError && typeof error.rule === "object" ? error.rule.name : "";
  const mend = () => {
    const kept = withLaws(registry, options, {}, options.system, options.drive ?? "fixed_pivot");
    // `withLaws` leaves out what belongs to other systems and drives, but not to another contact.
    if (MENDED[rule] === "leaveItOut" && error instanceof InputError) delete kept[String(error.parameter)];
    store.set({ options: { duration: textOf(registry, "duration", registry.options.duration.usual), ...kept } }, "preset");
  };
  return [
    ...(MENDED[rule] && options.system ? [{ label: t(MENDED[rule]), act: mend }] : []),
    ...(store.canGoBack ? [{ label: t("undo"), act: () => history.back() }] : []),
    ...(hasPreset ? [{ label: t("resetToPreset"), act: () => store.set({ options: {} }, "preset") }] : []),
  ];
}

/**
 * Take parts of what a view keeps in the address out of it, and name them on the stage.
 * @param {Page} page
 * @param {string[]} names in the address
 */
export function leaveOut(page, names) {
  const { extra, view } = page.store.state;
  const left = names.map((name) => /** @type {[string, string]} */ ([name, extra[name]]));
  page.store.drop(names);
  sayLeft(page, left, `link of ${view}`);
}

/**
 * Name on the stage what was left out of a link, until something else is chosen.
 * @param {Page} page
 * @param {[string, string][]} left names and texts of the address
 * @param {string} [about] whose part of the link
 */
export function sayLeft({ messages, store }, left, about = "link") {
  if (left.length) messages.showOfStep(about, t("leftOut", { parts: left.map(partText).join(", ") }), store);
}

/**
 * Return a part of a link as a message names it: on one line, and only its beginning if it is long.
 * @param {[string, string]} part its name and text
 */
export function partText([name, text]) {
  const line = `${name}=${text}`.replace(/\s+/g, " ");
  return `“${line.length > LONGEST ? t("cut", { text: line.slice(0, LONGEST) }) : line}”`;
}
