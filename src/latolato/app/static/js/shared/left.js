/** How much time work has left, by the rate that is measured while it goes on. */

import { t } from "../strings.js";

// Of shorter work nobody asks how much is left.
export const SOON = 5; // s
// A rate counts after this share of the work, or after this time and a smaller share.
const SHARE = 0.1;
const PATIENCE = 3; // s
const LEAST = 0.01;
// An end that was announced moves back only where it was off by more than this.
const OFF = 0.5; // of the time left
const MARGIN = 5; // s
// An end that comes sooner moves by this part of the difference.
const EASE = 0.2;
// Work that is silent for this time, and for so many of its usual pauses, did something else.
const HALT = 1.5; // s
const MANY = 5;
const MOMENT = 0.1; // s

export class TimeLeft {
  /**
   * @param {number | null} [expected] seconds that the work takes, if that was measured before
   * @param {() => number} [now] time [s]
   */
  constructor(expected = null, now = () => performance.now() / 1000) {
    this.now = now;
    this.share = 0;
    this.begun = now();
    this.first = 0;
    this.reports = 0;
    /** Part of the work that is done in a second, 0 before it was measured. */
    this.rate = 0;
    /** How much was done when, over the last half of the time. */
    this.marks = [{ time: this.begun, share: 0 }];
    /** @type {number | null} when the work ends */
    this.end = expected === null ? null : this.begun + expected;
  }

  /**
   * Measure from this moment on.
   * @param {number} share that is done already
   */
  begin(share) {
    this.begun = this.now();
    this.first = share;
    this.reports = 0;
    this.rate = 0;
    this.marks = [{ time: this.begun, share }];
  }

  /**
   * Take how much of the work is done.
   * @param {number} share
   */
  heed(share) {
    if (share <= this.share) return;
    const { marks, begun } = this;
    const now = this.now();
    const last = marks[marks.length - 1].time;
    const isHalt = this.reports > 0 && now - last > HALT
      && now - last > MANY * (last - begun) / this.reports;
    this.share = share;
    // Work done in no time, or before a halt, says nothing about the rest.
    if (isHalt || now - begun < MOMENT) {
      if (isHalt) this.end = null;
      this.begin(share);
      return;
    }
    this.reports += 1;
    marks.push({ time: now, share });
    while (marks.length > 2 && marks[1].time - begun <= 0.5 * (now - begun)) marks.shift();
    if (share - this.first < (now - begun < PATIENCE ? SHARE : LEAST)) return;
    this.rate = (share - marks[0].share) / (now - marks[0].time);
    const left = (1 - share) / this.rate;
    const announced = this.end === null ? 0 : this.end - now;
    // It comes sooner bit by bit, later only in a jump: to and fro it does not go.
    if (this.end === null || left > announced * (1 + OFF) + MARGIN) this.end = now + left;
    else if (left < announced) this.end += EASE * (left - announced);
  }

  /** Seconds that are left, null where that is not known or the end has passed. */
  get seconds() {
    const left = this.end === null ? 0 : this.end - this.now();
    return left > 0 ? left : null;
  }

  /** Whether the work takes longer than it should by what was measured. */
  get isLate() {
    return this.end !== null && this.now() >= this.end;
  }

  /** Seconds that all of it takes, null before that is known. */
  get total() {
    return this.end === null ? null : this.end - this.begun;
  }
}

/**
 * Return a time as people say it.
 * @param {number} seconds
 * @returns {string}
 */
export function spanText(seconds) {
  if (seconds >= 90) return t("minutes", { count: Math.round(seconds / 60) });
  const step = seconds < 10 ? 1 : 5;
  return t("seconds", { count: Math.max(step * Math.round(seconds / step), 1) });
}
