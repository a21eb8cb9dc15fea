/** What is on show, kept in the address: the view, the scenario and every option. */

/**
 * The address is `?view=toy&scenario=fig02&length=24.5 cm&map.x=frequency_ratio`: names without a
 * dot are options of the command line, those with one belong to the view before it. `lang` is the
 * language that the link asks for.
 * @typedef {{view: string, scenario: string | null, options: Record<string, string>,
 *   extra: Record<string, string>, lang?: string}} State
 */

/**
 * What all views are given: the server's registry, the state that they share, and the messages that
 * stand on the stage of the view on show. `curves` are texts of bifurcation curves that an analysis found.
 * @typedef {{curves?: string[], registry: any, store: import("./history.js").AddressStore,
 *   messages: import("./messages.js").Messages}} Page
 */

/** The scenario that is shown where the address names nothing. */
export const FIRST = "toy";
/** Where the address says that a hand holds the toy. */
export const HELD = "toy.hand";
/** What views of older versions are now. @type {Record<string, Partial<State>>} */
const FORMER = { play: { view: "toy" }, live: { view: "toy", extra: { [HELD]: "1" } },
  story: { view: "toy", extra: { "story.list": "1" } }, experiment: { view: "measure" } };
// "embed" stands in addresses of older versions, which showed a view without the bar.
const KEPT = ["view", "scenario", "embed", "format", "lang"];

/**
 * Return the state that an address holds.
 * @param {string} search
 * @returns {State}
 */
export function parse(search) {
  /** @type {State} */
  const state = { view: "toy", scenario: null, options: {}, extra: {} };
  /** @type {[string, string][]} */
  const others = [];
  for (const [name, value] of new URLSearchParams(search)) {
    if (name === "view") state.view = value;
    else if (name === "scenario") state.scenario = value;
    else if (name === "lang") state.lang = value;
    else if (!KEPT.includes(name)) others.push([name, value]);
  }
  // As properties of their own, whatever their names are.
  state.options = Object.fromEntries(others.filter(([name]) => !name.includes(".")));
  state.extra = Object.fromEntries(others.filter(([name]) => name.includes(".")));
  const former = Object.hasOwn(FORMER, state.view) ? FORMER[state.view] : {};
  const extra = Object.fromEntries(Object.entries(state.extra).map(([name, value]) =>
    [name.replace(/^experiment[.]/, "measure."), value]));
  return { ...state, ...former, extra: { ...extra, ...former.extra } };
}

/**
 * Return the address of a state.
 * @param {State} state
 * @returns {string}
 */
export function format(state) {
  const query = new URLSearchParams();
  query.set("view", state.view);
  if (state.scenario) query.set("scenario", state.scenario);
  if (state.lang) query.set("lang", state.lang);
  for (const part of [state.options, state.extra])
    for (const name of Object.keys(part).sort()) query.set(name, part[name]);
  return `?${query}`;
}

/**
 * Return whether this version reads an address: one without a format is of format 1.
 * @param {string} search
 * @param {number} newest format that this version knows
 */
export function isReadable(search, newest) {
  const number = Number(new URLSearchParams(search).get("format") ?? 1);
  return Number.isInteger(number) && number >= 1 && number <= newest;
}

/** A state that others may listen to. */
export class Store {
  /** @param {State} state */
  constructor(state) {
    this.state = state;
    /** @type {((state: State, changed: string) => void)[]} */
    this.listeners = [];
  }

  /**
   * Call a function at every change; returns what ends that.
   * @param {(state: State, changed: string) => void} listener
   */
  subscribe(listener) {
    this.listeners.push(listener);
    return () => { this.listeners = this.listeners.filter((each) => each !== listener); };
  }

  /**
   * Change parts of the state.
   * @param {Partial<State>} part
   * @param {string} [changed] what it is: "view", "preset", "options" or "extra"
   */
  set(part, changed = "options") {
    this.state = { ...this.state, ...part };
    this.notify(changed);
  }

  /**
   * Set one option, or take it back with null.
   * @param {string} name
   * @param {string | null} value
   */
  option(name, value) {
    const options = { ...this.state.options };
    if (value === null) delete options[name];
    else options[name] = value;
    this.set({ options });
  }

  /**
   * Set what a view keeps in the address.
   * @param {string} name such as "map.x"
   * @param {string | null} value
   */
  keep(name, value) {
    const extra = { ...this.state.extra };
    if (value === null) delete extra[name];
    else extra[name] = value;
    this.set({ extra }, "extra");
  }

  /** @param {string} changed */
  notify(changed) {
    // One listener may end another: a view that is left hears of nothing more.
    for (const listener of [...this.listeners])
      if (this.listeners.includes(listener)) listener(this.state, changed);
  }
}
