/** The state of the page in its address: what people change makes entries of the browser's history, so Back undoes it. */

import { format, parse, Store } from "./state.js";

/** @typedef {import("./state.js").State} State */

// Changes that follow each other faster than this are one entry, and so are those of one press of a pointer.
// This also stays within what browsers accept: Safari 100 changes of the history in 30 s, others 200 in 10 s.
const PAUSE = 400; // ms

/** The one state of the page, which is kept in the address. */
export class AddressStore extends Store {
  /** @param {Window} page */
  constructor(page) {
    super(parse(page.location.search));
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
   * Change parts of the state, in a new entry or in the present one if the same gesture changes it further.
   * @param {Partial<State>} part
   * @param {string} [changed]
   */
  set(part, changed = "options") {
    const before = format(this.state);
    this.state = { ...this.state, ...part };
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
   * Take parts of `extra` out of the address, without an entry.
   * @param {string[]} names
   */
  drop(names) {
    this.amend({ extra: Object.fromEntries(Object.entries(this.state.extra)
      .filter(([name]) => !names.includes(name))) });
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
