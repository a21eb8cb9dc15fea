/** Which parts of a link can be read: the others are left out, and named on the stage. */

import { valueOf } from "../model/options.js";
import { checkedNumber, InputError } from "../model/rules.js";
import { t } from "../strings.js";
import { withLaws } from "./option_texts.js";
import { inPagesWords } from "./refusals.js";
import { FIRST } from "./state.js";
import { short, shownUnit } from "./unit_text.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Page} Page */
/** @typedef {import("../model/registry.js").Registry} Registry */

// Longer texts of a link are not repeated.
const LONGEST = 60;
// What a link may hold of views that read all of theirs; others name what they cannot read themselves.
const PARTS = /** @type {Record<string, string[]>} */ ({
  toy: ["hand"], report: [],
  story: ["list", "name", "step", "answers", "tried", "guess"],
});
// Views that show one run; a sweep opens in Map.
const OF_RUNS = ["toy", "analyse"];

/**
 * Return the state that remains of a link without what cannot be read, and the names and texts of what
 * that was. What a view keeps in the address is read by that view.
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
  const options = readableOptions(registry, { ...state, scenario }, left);
  const extra = Object.fromEntries(Object.entries(state.extra).filter(([name, text]) => {
    const [owner, ...part] = name.split(".");
    const isKnown = Object.hasOwn(PARTS, owner) ? PARTS[owner].includes(part.join(".")) : views.includes(owner);
    if (!isKnown) left.push([name, text]);
    return isKnown;
  }));
  return { state: { ...state, view, scenario, options, extra }, left };
}

/**
 * Return the options of a link that can be read, and put what cannot into `left`.
 * @param {Registry} registry
 * @param {State} state
 * @param {[string, string][]} left
 * @returns {Record<string, string>}
 */
function readableOptions(registry, { scenario, options: all }, left) {
  /** @type {Record<string, string>} */
  let options = Object.fromEntries(Object.entries(all).filter(([name, text]) => isValid(registry, name, text)));
  const given = registry.scenarios[scenario ?? FIRST].given;
  const system = options.system ?? given.system;
  const drive = options.drive ?? driveOf(registry, scenario || !options.system ? given : {}, options);
  const laws = { system, drive, contact: options.contact ?? given.contact ?? "exact" };
  options = Object.fromEntries(Object.entries(options).filter(([name, text]) => isOf(registry, name, text, laws)));
  left.push(...Object.entries(all).filter(([name]) => !Object.hasOwn(options, name)));
  // What an own system lacks now is as usual.
  if (left.length && !scenario && options.system)
    options = withLaws(registry, options, {}, system, drive ?? "fixed_pivot");
  return options;
}

/**
 * Return whether a text is a value of an option, whatever the others are.
 * @param {Registry} registry
 * @param {string} name
 * @param {string} text
 */
function isValid(registry, name, text) {
  const laws = { system: registry.systems, drive: registry.drives }[name];
  if (!Object.hasOwn(registry.options, name)) return false;
  if (laws) return Object.hasOwn(laws, text);
  const option = registry.options[name];
  try {
    const value = valueOf(registry, name, text);
    if (option.choices.length && !option.choices.includes(value)) return false;
    if (option.several && !value.length) return false;
    if (option.unit || option.whole) for (const each of [value].flat()) checkedNumber(option, name, each);
    return true;
  } catch (error) {
    if (error instanceof InputError) return false;
    throw error;
  }
}

/**
 * Return the drive of a preset whose parameters are replaced: those of a drive begin to shake a pivot.
 * @param {Registry} registry
 * @param {Record<string, any>} given
 * @param {Record<string, string>} options
 */
function driveOf(registry, { drive = "fixed_pivot" }, options) {
  const isShaken = Object.keys(options).some((name) => registry.options[name].owner === "drive");
  return drive === "fixed_pivot" && isShaken ? "harmonic" : drive;
}

/**
 * Return whether these laws have an option, for as many balls as its text gives values.
 * @param {Registry} registry
 * @param {string} name
 * @param {string} text
 * @param {{system: string, drive: string | null, contact: string}} laws the drive is null if it is not known
 */
function isOf(registry, name, text, { system, drive, contact }) {
  const { owner, for_each_ball: isForEach } = registry.options[name];
  const law = registry.systems[system];
  if (name === "system" || name === "drive") return true;
  if (owner === "system" && !law.options.includes(name)) return false;
  if (owner === "drive" && drive && !registry.drives[drive].options.includes(registry.ratios[name] ?? name)) return false;
  if (name === "initial_offset" && system !== "latolato") return false;
  const owners = Object.entries(registry.contact_laws).filter(([, each]) => each.options.includes(name));
  if (owners.length && !owners.some(([each]) => each === contact)) return false;
  return !isForEach || text.includes(",") === (law.angles === 2) || Number.parseFloat(text) === 0;
}

/**
 * Return an error as a sentence of the page.
 * @param {Registry} registry
 * @param {Error} error
 */
export function sentence(registry, error) {
  const [text] = inPagesWords(registry, error);
  return stopped(`${text.charAt(0).toUpperCase()}${text.slice(1)}`);
}

/**
 * Return a text that ends like a sentence.
 * @param {string} text
 */
export function stopped(text) {
  return /[.?!]$/.test(text) ? text : `${text}.`;
}

/**
 * Return the value next to one that lies beyond the range of its option, as the option's text and as
 * people read it; null where no value is the next one.
 * @param {Registry} registry
 * @param {Error} error
 * @returns {{name: string, text: string, shown: string} | null}
 */
export function nearestAllowed(registry, error) {
  if (!(error instanceof InputError) || !error.parameter) return null;
  const { parameter: name, about: { value } } = error;
  const option = registry.options[name];
  if (!option || !Number.isFinite(Number(value)) || typeof value === "string") return null;
  const end = [option.low, option.high].find((each, k) => each !== null
    && (k ? Number(value) > each : Number(value) < each)
    && option.limits.some((limit) => limit.end === each && !limit.is_open));
  if (end === null || end === undefined) return null;
  const unit = option.units[0] ?? { name: "", size: 1 };
  const number = short(end / unit.size);
  const isPlain = !unit.name || unit.name === "1";
  return { name, text: isPlain ? number : `${number} ${unit.name}`,
    shown: `${number} ${shownUnit(unit.name)}`.trim() };
}

/**
 * The actions that can help with a refused run.
 * @param {Page} page
 * @param {Error} error
 * @returns {import("./messages.js").MessageAction[]}
 */
export function waysOn({ registry, store }, error) {
  const nearest = nearestAllowed(registry, error);
  const { scenario, options } = store.state;
  const hasPreset = (scenario !== null || !options.system) && Object.keys(options).length > 0;
  return [
    ...(nearest ? [{ label: t("takeNearest", { value: nearest.shown }),
      act: () => store.option(nearest.name, nearest.text) }] : []),
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
  if (names.length) page.store.drop(names);
  sayLeft(page, left, `link of ${view}`);
}

/**
 * Name on the stage what was left out of a link, until something else is chosen.
 * @param {Page} page
 * @param {[string, string][]} left names and texts of the address
 * @param {string} [about] whose part of the link
 */
export function sayLeft({ messages, store }, left, about = "link") {
  if (!left.length) return;
  messages.show(about, t("leftOut", { parts: left.map(partText).join(", ") }), { stays: true });
  const { step } = store;
  const end = store.subscribe(() => {
    if (store.step === step) return;
    end();
    messages.drop(about);
  });
}

/**
 * Return a part of a link as a message names it: on one line, and only its beginning if it is long.
 * @param {[string, string]} part its name and text
 */
export function partText([name, text]) {
  const line = `${name}=${text}`.replace(/\s+/g, " ");
  return `“${line.length > LONGEST ? t("cut", { text: line.slice(0, LONGEST) }) : line}”`;
}
