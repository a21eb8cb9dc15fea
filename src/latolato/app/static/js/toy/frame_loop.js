/** How far a toy moves on with each picture: real time, slower where a machine cannot follow. */

import { LONGEST } from "./toy.js";

/** @typedef {import("./toy.js").Toy} Toy */

// A toy that was kept from moving for longer goes on from where it is.
export const MOST_BEHIND = 0.25; // s
// Of each picture this is for computing; what does not fit is left out, and the toy is slow.
const BUDGET = 12; // ms
// The share of real time is that of so long.
const MEASURED = 1000; // ms

export class FrameLoop {
  /** @param {() => number} clock in ms */
  constructor(clock = () => performance.now()) {
    this.clock = clock;
    /** Seconds of the toy in a second. */
    this.speed = 1;
    /** The share of the speed that this machine reaches. */
    this.share = 1;
    /** @type {number | null} */
    this.before = null;
    this.wanted = this.moved = 0;
  }

  /** Leave out the time since the last picture. */
  rest() {
    this.before = null;
    this.wanted = this.moved = 0;
  }

  /**
   * Move a toy on to a picture.
   * @param {Toy} toy
   * @param {number} now in ms
   * @param {() => void} moved called each time that it moved on
   */
  move(toy, now, moved) {
    const since = now - (this.before ?? now);
    this.before = now;
    const begun = toy.time;
    const until = begun + this.speed * Math.min(since / 1000, MOST_BEHIND);
    const stop = this.clock() + BUDGET;
    while (toy.time < until && this.clock() < stop) {
      const next = Math.min(toy.time + LONGEST, until);
      toy.advance(next, now - (1000 * (until - next)) / this.speed);
      moved();
    }
    this.wanted += since;
    this.moved += (1000 * (toy.time - begun)) / this.speed;
    if (this.wanted < MEASURED) return;
    this.share = this.moved / this.wanted;
    this.wanted = this.moved = 0;
  }
}
