/**
 * What is on show, kept in the address: the view, the scenario and every option. What people change makes
 * entries of the browser's history, so Back undoes it.
 */

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
 * @typedef {{curves?: string[], registry: any, store: Store,
 *   messages: import("./messages.js").Messages}} Page
 */

/** The scenario that is shown where the address names nothing. */
export const FIRST = "toy";
/** Where the address says that a hand holds the toy. */
export const HELD = "toy.hand";
/** Where the address says that what it was taken from was played by hand, which no address repeats. */
export const PLAYED = "toy.kept";
/** What views of older versions are now. @type {Record<string, Partial<State>>} */
const FORMER = { play: { view: "toy" }, live: { view: "toy", extra: { [HELD]: "1" } },
  story: { view: "toy", extra: { "story.list": "1" } }, experiment: { view: "measure" } };
// "embed" stands in addresses of older versions, which showed a view without the bar.
const KEPT = ["view", "scenario", "embed", "format", "lang"];

// Changes that follow each other faster than this are one entry, and so are those of one press of a pointer.
// This also stays within what browsers accept: Safari 100 changes of the history in 30 s, others 200 in 10 s.
const PAUSE = 400; // ms

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

/**
 * @param {Record<string, string>} extra
 * @param {string[]} names
 */
function withoutNames(extra, names) {
  return Object.fromEntries(Object.entries(extra).filter(([name]) => !names.includes(name)));
}

/** The one state of the page, which is kept in the address and to which others may listen. */
export class Store {
  /** @param {Window} page */
  constructor(page) {
    this.state = parse(page.location.search);
    /** @type {((state: State, changed: string) => void)[]} */
    this.listeners = [];
    this.page = page;
    // An entry of a frame would be one of the page around it, which has a Back button of its own.
    this.hasEntries = page.parent === page;
    /** Number of the present entry; a page that is loaded again goes on counting. @type {number} */
    this.step = (this.hasEntries && page.history.state?.step) || 0;
    /** Whether the next change may belong to the present entry. */
    this.goesOn = false;
    this.changedAt = 0;
    this.isHeld = false;
    /** Of a change that is not yet in the address. */
    this.timer = 0;
    page.history.replaceState({ step: this.step }, "");
    page.addEventListener("popstate", (event) => this.arrive(event.state?.step));
    page.addEventListener("pagehide", () => this.write());
    const end = () => {
      this.isHeld = this.goesOn = false;
      this.write();
    };
    page.addEventListener("pointerdown", () => {
      end();
      this.isHeld = true;
    }, { capture: true });
    // A text that was typed is an entry, and so is a press of a pointer. What they change comes first.
    for (const name of ["pointerup", "pointercancel", "change"])
      page.addEventListener(name, () => this.page.setTimeout(end), { capture: true });
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
   * Change parts of the state, in a new entry or in the present one if the same gesture changes it further.
   * @param {Partial<State>} part
   * @param {string} [changed] what it is: "view", "preset", "options" or "extra"
   */
  set(part, changed = "options") {
    const before = format(this.state);
    this.state = { ...this.state, ...part };
    // New parameters ask for the run that they describe, not for what was played by hand.
    if ("options" in part) this.state.extra = withoutNames(this.state.extra, [PLAYED]);
    const address = format(this.state);
    if (address !== before) {
      const isWhole = ["view", "preset"].includes(changed);
      const now = performance.now();
      const goesOn = !isWhole && this.goesOn && (this.isHeld || now - this.changedAt < PAUSE);
      this.goesOn = !isWhole;
      this.changedAt = now;
      if (goesOn || !this.hasEntries) this.writeLater();
      else {
        this.step += 1;
        this.page.history.pushState({ step: this.step }, "", address);
      }
    }
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

  /**
   * Take parts of `extra` out of the address, without an entry; returns whether there were any.
   * @param {string[]} names
   */
  drop(names) {
    const { extra } = this.state;
    const isAny = names.some((name) => name in extra);
    if (isAny) this.amend({ extra: withoutNames(extra, names) });
    return isAny;
  }

  /**
   * Change parts of the state in the present entry: what follows from the last change, or changes no run.
   * @param {Partial<State>} part
   * @param {string} [changed]
   */
  amend(part, changed = "extra") {
    this.state = { ...this.state, ...part };
    this.writeLater();
    this.notify(changed);
  }

  /** Write the state into the present entry when it has been left alone for a while. */
  writeLater() {
    clearTimeout(this.timer);
    this.timer = this.page.setTimeout(() => this.write(), PAUSE);
  }

  /** Write a change that is not yet in the address. */
  write() {
    if (!this.timer) return;
    clearTimeout(this.timer);
    this.timer = 0;
    this.page.history.replaceState({ step: this.step }, "", format(this.state));
  }

  /**
   * Show the entry to which the browser has gone.
   * @param {number} [step] its number; a link to a part of the page makes an entry without
   */
  arrive(step) {
    clearTimeout(this.timer);
    this.timer = 0;
    this.goesOn = false;
    this.step = step ?? this.step;
    const state = parse(this.page.location.search);
    if (format(state) === format(this.state)) return;
    this.state = state;
    this.notify("address");
  }

  /** Whether there is an entry of this page before the present one. */
  get canGoBack() {
    return this.hasEntries && this.step > 0;
  }
}
