/** Which parts of a link can be read: the others are left out, and named on the stage. */

import { valueOf } from "../model/options.js";
import { checkedNumber, InputError, noList } from "../model/rules.js";
import { t } from "../strings.js";
import { withLaws } from "./laws.js";
import { inPagesWords } from "./refusals.js";
import { FIRST } from "./state.js";
import { short, shownUnit } from "./units.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Page} Page */
/** @typedef {import("../model/registry.js").Registry} Registry */

/**
 * What was left out of a link: a sentence about it, and what a button of this label would show instead,
 * another state or an option with another value.
 * @typedef {{text: string, label?: string, part?: Partial<State>, option?: [string, string]}} Left
 */

// Longer texts of a link are not repeated.
const LONGEST = 60;
// What a link may hold of views that read all of theirs; others name what they cannot read themselves.
const PARTS = /** @type {Record<string, string[]>} */ ({
  toy: ["hand"], report: [],
  story: ["list", "name", "step", "answers", "tried", "guess"],
});
// Views that show one run, not a sweep.
const OF_RUNS = ["toy", "analyse"];

/**
 * Return the state that remains of a link without what cannot be read, and what that was. What a view
 * keeps in the address is read by that view.
 * @param {Registry} registry
 * @param {State} state
 * @param {string[]} views
 * @returns {{state: State, left: Left[]}}
 */
export function readable(registry, state, views) {
  /** @type {Left[]} */
  const left = [];
  let { view } = state;
  let scenario = state.scenario || null;
  if (!views.includes(view)) {
    left.push({ text: t("unknownView", { name: cut(view) }) });
    view = "toy";
  }
  const preset = scenario && Object.hasOwn(registry.scenarios, scenario) ? registry.scenarios[scenario] : null;
  if (scenario && !preset) {
    left.push({ text: t("unknownPreset", { name: cut(scenario) }), label: t("firstPreset"),
      part: { scenario: FIRST, options: {} } });
    scenario = null;
  } else if (scenario && preset?.sweep && OF_RUNS.includes(view)) {
    left.push({ text: t("presetIsMap", { title: preset.title }), label: t("openInMap"),
      part: { view: "map", scenario, options: {} } });
    scenario = null;
  }
  const options = readableOptions(registry, { ...state, scenario }, left);
  const extra = Object.fromEntries(Object.entries(state.extra).filter(([name]) => {
    const [owner, ...part] = name.split(".");
    const isKnown = Object.hasOwn(PARTS, owner) ? PARTS[owner].includes(part.join(".")) : views.includes(owner);
    if (!isKnown) left.push({ text: t("unknownParameter", { name: cut(name) }) });
    return isKnown;
  }));
  return { state: { ...state, view, scenario, options, extra }, left };
}

/**
 * Return a text of a link on one line, and only its beginning if it is long.
 * @param {string} text
 */
export function cut(text) {
  const line = text.replace(/\s+/g, " ");
  return line.length > LONGEST ? t("cut", { text: line.slice(0, LONGEST) }) : line;
}

/**
 * Return the options of a link that can be read, and put what cannot into `left`.
 * @param {Registry} registry
 * @param {State} state
 * @param {Left[]} left
 * @returns {Record<string, string>}
 */
function readableOptions(registry, { scenario, options: all }, left) {
  /** @type {Record<string, string>} */
  let options = {};
  for (const [name, text] of Object.entries(all)) {
    const laws = { system: registry.systems, drive: registry.drives }[name];
    if (name === "preset" && !Object.hasOwn(registry.options, name))
      left.push(presetByAnotherName(registry, text));
    else if (!Object.hasOwn(registry.options, name))
      left.push({ text: t("unknownParameter", { name: cut(name) }) });
    else if (laws && !Object.hasOwn(laws, text))
      left.push({ text: t(name === "system" ? "unknownSystem" : "unknownDrive", { name: cut(text) }) });
    else {
      const error = faultOf(registry, name, text);
      const nearest = error && nearestAllowed(registry, error);
      if (error) left.push({ text: sentence(registry, error), ...(nearest && {
        label: t("showWith", { value: nearest.shown }), option: [name, nearest.text] }) });
      else options[name] = text;
    }
  }
  const given = registry.scenarios[scenario ?? FIRST].given;
  const system = options.system ?? given.system;
  const drive = options.drive ?? driveOf(registry, scenario || !options.system ? given : {}, options);
  for (const [name, text] of Object.entries(options)) {
    const { label, for_each_ball: isForEach } = registry.options[name];
    const law = strangerTo(registry, name, { system, drive, contact: options.contact ?? given.contact ?? "exact" });
    const isTwo = registry.systems[system].angles === 2;
    if (law !== null) left.push({ text: t("strangeParameter", { label, law }) });
    else if (isForEach && text.includes(",") !== isTwo && Number.parseFloat(text) !== 0)
      left.push({ text: t(isTwo ? "notForTwo" : "notForOne", { label, text: cut(text) }) });
    else continue;
    delete options[name];
  }
  // What an own system lacks now is as usual.
  if (left.length && !scenario && options.system)
    options = withLaws(registry, options, {}, system, drive ?? "fixed_pivot");
  return options;
}

/**
 * The message for a link that names a preset by a key that does not exist.
 * @param {Registry} registry
 * @param {string} name of the preset
 * @returns {Left}
 */
function presetByAnotherName(registry, name) {
  const text = t("presetKey", { name: cut(name) });
  const preset = Object.hasOwn(registry.scenarios, name) ? registry.scenarios[name] : null;
  if (!preset || preset.sweep) return { text };
  return { text, label: t("showPreset", { title: preset.title }), part: { scenario: name, options: {} } };
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
 * Return why the value of one option cannot be read, whatever the others are; null if it can.
 * @param {Registry} registry
 * @param {string} name
 * @param {string} text
 */
function faultOf(registry, name, text) {
  const option = registry.options[name];
  const { choices } = option;
  try {
    const value = valueOf(registry, name, text);
    if (choices.length && !choices.includes(value))
      throw new InputError(`must be one of ${choices.join(", ")}`, { parameter: name, value });
    if (option.several && !value.length)
      throw noList(option.unit, { parameter: name, value: text });
    if (option.unit || option.whole) for (const each of [value].flat()) checkedNumber(option, name, each);
    return null;
  } catch (error) {
    if (!(error instanceof InputError)) throw error;
    const { value } = error.about;
    return typeof value === "string"
      ? new InputError(error.rule, { ...error.about, value: cut(value) }) : error;
  }
}

/**
 * Return the title of the law that an option does not belong to, null if it fits.
 * @param {Registry} registry
 * @param {string} name
 * @param {{system: string, drive: string | null, contact: string}} laws the drive is null if it is not known
 */
function strangerTo(registry, name, { system, drive, contact }) {
  const { owner } = registry.options[name];
  const law = registry.systems[system];
  if (name === "system" || name === "drive") return null;
  if (owner === "system" && !law.options.includes(name)) return law.title;
  if (owner === "drive" && drive && !registry.drives[drive].options.includes(registry.ratios[name] ?? name))
    return registry.drives[drive].title;
  if (name === "initial_offset" && system !== "latolato") return law.title;
  const owners = Object.entries(registry.contact_laws).filter(([, each]) => each.options.includes(name));
  if (owners.length && !owners.some(([each]) => each === contact)) return registry.contact_laws[contact].title;
  return null;
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
 * @returns {import("./messages.js").Action[]}
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
 * @param {Record<string, Left>} left by their names in the address
 */
export function leaveOut(page, left) {
  const names = Object.keys(left);
  if (names.length) page.store.drop(names);
  sayLeft(page, Object.values(left), `link of ${page.store.state.view}`);
}

/**
 * Name on the stage what was left out of a link.
 * @param {Page} page
 * @param {Left[]} left
 * @param {string} [about] whose part of the link
 */
export function sayLeft(page, left, about = "link") {
  if (!left.length) return;
  const { messages, store } = page;
  const actions = left.flatMap(({ label, part, option }) => (label ? [{ label, act: () => {
    if (part) store.set(part, "preset");
    if (option) store.option(...option);
  } }] : []));
  messages.say(about, [t("leftOut"), ...left.map(({ text }) => text)].join(" "), { stays: true, actions });
  // Until something else is chosen.
  const { step } = store;
  const end = store.subscribe(() => {
    if (store.step === step) return;
    end();
    messages.drop(about);
  });
}
