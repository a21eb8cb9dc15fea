/** The state of the page in its address, and undo and redo: its steps are entries of the browser's history. */

import { el } from "./dom.js";
import { format, parse, Store } from "./state.js";
import { t } from "../strings.js";

/** @typedef {import("./state.js").State} State */

// Changes of the same parameters are one step, as long as the pauses between them are shorter.
const PAUSE = 1000; // ms
// A step that is still changing is written when it has been left alone for this time.
const WRITE_AFTER = 150; // ms
// Browsers refuse more changes of the history than this: Safari 100 in 30 s, others 200 in 10 s.
const MOST_WRITES = 90;
const PERIOD = 30_000; // ms
// Browsers keep 50 entries and forget the oldest.
const MOST_STEPS = 49;

/** The steps from the first state of a page to the present one, and those that were undone. */
export class Steps {
  /**
   * @param {Window} page
   * @param {State} state what the page begins with
   * @param {(state: State) => void} show called with the state of the step that was gone to
   */
  constructor(page, state, show) {
    this.page = page;
    this.show = show;
    // An entry of a frame would be one of the page around it, which has a Back button of its own.
    this.hasEntries = page.parent === page;
    /** @type {number} number of the step on show; a page that is loaded again goes on counting */
    this.step = (this.hasEntries && page.history.state?.step) || 0;
    this.last = this.step;
    /** @type {State[]} as far as this visit knows them */
    this.states = [];
    this.states[this.step] = state;
    /** @type {string[] | null} what the changes of the present gesture have changed */
    this.names = null;
    this.changedAt = 0;
    this.isHeld = false;
    /** @type {number | null} the step that is gone to, until the browser is there */
    this.aim = null;
    this.timer = 0;
    /** @type {Set<number>} steps that were left before their last change was written */
    this.unwritten = new Set();
    /** @type {number[]} times of the last changes of the history */
    this.writes = [];
    /** @type {(() => void)[]} */
    this.listeners = [];
    page.history.replaceState({ step: this.step }, "");
    page.addEventListener("popstate", (event) => this.arrive(event.state?.step));
    page.addEventListener("pagehide", () => this.flush());
    const hold = (/** @type {boolean} */ isHeld) => () => {
      this.isHeld = isHeld;
      if (isHeld) this.names = null;
    };
    // Each text that is typed is a step.
    page.addEventListener("change", ({ target }) => {
      if (isForText(target)) this.names = null;
    }, { capture: true });
    page.addEventListener("pointerdown", hold(true), { capture: true });
    page.addEventListener("pointerup", hold(false), { capture: true });
    page.addEventListener("pointercancel", hold(false), { capture: true });
  }

  get canUndo() {
    return (this.aim ?? this.step) > Math.max(0, this.last - MOST_STEPS);
  }

  get canRedo() {
    return (this.aim ?? this.step) < this.last;
  }

  /**
   * Take a state into a new step, or into the present one if the same gesture changes it further.
   * @param {State} state
   * @param {string[]} names of what has changed
   * @param {boolean} isWhole whether the change is a step by itself
   */
  take(state, names, isWhole) {
    const now = performance.now();
    const goesOn = !isWhole && this.names !== null && names.every((each) => this.names?.includes(each))
      && (this.isHeld || now - this.changedAt < PAUSE);
    this.names = isWhole ? null : names;
    this.changedAt = now;
    if (goesOn || !this.mayWrite()) {
      this.amend(state);
      return;
    }
    this.flush();
    this.aim = null;
    this.step += 1;
    this.last = this.step;
    this.states.length = this.step;
    this.states[this.step] = state;
    this.page.history[this.hasEntries ? "pushState" : "replaceState"](
      { step: this.step }, "", format(state));
    this.tell();
  }

  /**
   * Change the state of the present step.
   * @param {State} state
   */
  amend(state) {
    this.states[this.step] = state;
    clearTimeout(this.timer);
    this.timer = this.page.setTimeout(() => this.flush(), WRITE_AFTER);
  }

  /** Write a change that waits for being written. */
  flush() {
    if (!this.timer) return;
    clearTimeout(this.timer);
    this.timer = 0;
    if (this.mayWrite()) this.write();
    else this.amend(this.states[this.step]);
  }

  write() {
    this.page.history.replaceState({ step: this.step }, "", format(this.states[this.step]));
  }

  /** Return whether browsers accept one more change of the history now. */
  mayWrite() {
    const now = performance.now();
    this.writes = this.writes.filter((at) => now - at < PERIOD);
    if (this.writes.length >= MOST_WRITES) return false;
    this.writes.push(now);
    return true;
  }

  /**
   * Go to the step before the present one, or to the one after it, and never out of the page.
   * @param {-1 | 1} by
   */
  go(by) {
    if (!(by < 0 ? this.canUndo : this.canRedo)) return;
    this.flush();
    const isOnItsWay = this.aim !== null;
    this.aim = (this.aim ?? this.step) + by;
    if (!this.hasEntries) this.arrive(this.aim);
    else if (!isOnItsWay) this.page.history.go(by);
    this.tell();
  }

  /**
   * Show the step at which the browser has arrived.
   * @param {number | undefined} found its number; a link to a part of the page makes an entry without
   */
  arrive(found) {
    if (this.timer) this.unwritten.add(this.step);
    clearTimeout(this.timer);
    this.timer = 0;
    this.names = null;
    if (found === undefined) this.states[this.step + 1] = this.states[this.step];
    this.step = found ?? this.step + 1;
    this.last = Math.max(this.last, this.step);
    this.states[this.step] ??= parse(this.page.location.search);
    if (this.unwritten.delete(this.step) || found === undefined || !this.hasEntries) this.write();
    const left = (this.aim ?? this.step) - this.step;
    if (left) this.page.history.go(left);
    else {
      this.aim = null;
      this.show(this.states[this.step]);
    }
    this.tell();
  }

  /**
   * Call a function whenever there is something else to undo or to redo.
   * @param {() => void} listener
   */
  subscribe(listener) {
    this.listeners.push(listener);
  }

  tell() {
    for (const listener of this.listeners) listener();
  }
}

/**
 * Return the names of what differs between two states.
 * @param {State} before
 * @param {State} after
 * @returns {string[]}
 */
function differences(before, after) {
  const flat = (/** @type {State} */ { options, extra, ...rest }) => ({ ...rest, ...options, ...extra });
  /** @type {[Record<string, any>, Record<string, any>]} */
  const [a, b] = [flat(before), flat(after)];
  return [...new Set([...Object.keys(a), ...Object.keys(b)])].filter((name) => a[name] !== b[name]);
}

/** The one state of the page, which is kept in the address; its changes are steps to be undone. */
export class AddressStore extends Store {
  /** @param {Window} page */
  constructor(page) {
    super(parse(page.location.search));
    this.steps = new Steps(page, this.state, (state) => {
      this.state = state;
      this.tell("address");
    });
  }

  /**
   * Change parts of the state as a step, or as a part of one: see `Steps`.
   * @param {Partial<State>} part
   * @param {string} [changed]
   */
  set(part, changed = "options") {
    const before = this.state;
    this.state = { ...before, ...part };
    const names = differences(before, this.state);
    if (names.length) this.steps.take(this.state, names, ["view", "preset"].includes(changed));
    this.tell(changed);
  }

  /**
   * Take parts of `extra` out of the address, which is no step.
   * @param {string[]} names
   */
  drop(names) {
    this.amend({ extra: Object.fromEntries(Object.entries(this.state.extra)
      .filter(([name]) => !names.includes(name))) });
  }

  /**
   * Change parts of the state without a step: what follows from the last change, or changes no run.
   * @param {Partial<State>} part
   * @param {string} [changed]
   */
  amend(part, changed = "extra") {
    this.state = { ...this.state, ...part };
    this.steps.amend(this.state);
    this.tell(changed);
  }
}

/** @type {WeakSet<EventTarget>} fields with text that was typed and not yet taken */
const drafts = new WeakSet();

/** Return whether a text is typed in an element. */
function isForText(/** @type {EventTarget | null} */ target) {
  return target instanceof HTMLTextAreaElement || (target instanceof HTMLInputElement
    && ["text", "number", "search"].includes(target.type));
}

/**
 * Let the usual keys undo and redo steps; in a field whose text is not yet taken they belong to that.
 * @param {Window} page
 * @param {Steps} steps
 */
export function followUndoKeys(page, steps) {
  page.addEventListener("input", ({ target }) => {
    if (target && isForText(target)) drafts.add(target);
  }, { capture: true });
  for (const taken of ["change", "focusout"])
    page.addEventListener(taken, ({ target }) => target && drafts.delete(target), { capture: true });
  page.addEventListener("keydown", (event) => {
    const { ctrlKey, metaKey, altKey, shiftKey, target } = event;
    const key = event.key.toLowerCase();
    const isRedo = (key === "z" && shiftKey) || (key === "y" && ctrlKey && !shiftKey);
    if (event.defaultPrevented || altKey || !(ctrlKey || metaKey)) return;
    if (!(isRedo || key === "z") || (target && drafts.has(target))) return;
    event.preventDefault();
    steps.go(isRedo ? 1 : -1);
  });
}

/**
 * Return the buttons that undo and redo.
 * @param {Steps} steps
 */
export function undoButtons(steps) {
  const button = (/** @type {-1 | 1} */ by, /** @type {string} */ name, /** @type {string} */ sign,
    /** @type {string} */ keys) => el("button", { type: "button", title: t(name), "aria-label": t(name),
    "aria-keyshortcuts": keys, on: { click: () => steps.go(by) } }, sign);
  const undo = button(-1, "undo", "↶", "Control+Z Meta+Z");
  const redo = button(1, "redo", "↷", "Control+Shift+Z Control+Y Meta+Shift+Z");
  const show = () => {
    undo.disabled = !steps.canUndo;
    redo.disabled = !steps.canRedo;
  };
  steps.subscribe(show);
  show();
  return [undo, redo];
}
