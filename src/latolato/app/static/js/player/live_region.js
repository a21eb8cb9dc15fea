/** When to say something about a motion: a sentence at a time, as fast as a person can follow. */

import { bestSentence, inText, isNews, placesOf, startSentence } from "./describe.js";
import { logOf } from "./events.js";

/** @typedef {import("./describe.js").SpokenSentence} SpokenSentence */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./events.js").Log} Log */

// Sentences follow each other by at least this time of the page.
const GAP = 3000; // ms
// A change is mentioned when nothing was changed for so long.
const SETTLE = 700; // ms
// Playing from before this instant is playing from the beginning.
const BEGINNING = 1; // s
// More parameters change at once only where another motion is chosen.
const MOST_CHANGES = 2;

export class LiveRegion {
  /**
   * @param {HTMLElement} line that screen readers read aloud when it changes
   * @param {HTMLElement} about what the stage shows, where a reader looks for that
   * @param {() => void} onDescribe called when the stage is described again, so that others are as well
   * @param {(option: string) => string | undefined} nameOf returns what an option is called, if its
   *   changes are to be mentioned
   */
  constructor(line, about, onDescribe, nameOf) {
    this.line = line;
    this.about = about;
    this.onDescribe = onDescribe;
    this.nameOf = nameOf;
    /** @type {Motion | null} */
    this.motion = null;
    /** The events of a run, once they are asked for. @type {Log | null} */
    this.logOfRun = null;
    this.isPlaying = false;
    this.time = 0;
    this.announcedAt = -Infinity;
    this.from = 0;
    this.since = 0;
    /** @type {SpokenSentence | null} */
    this.last = null;
    /** The options before changes that are not yet mentioned. @type {Record<string, any> | null} */
    this.before = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
  }

  /** The events of the motion that is followed. @returns {Log} */
  get log() {
    const motion = /** @type {Motion} */ (this.motion);
    return motion.log ?? (this.logOfRun ??= logOf(motion));
  }

  /** @param {Motion | null} motion that is on show from now on */
  show(motion) {
    this.motion = motion;
    this.logOfRun = null;
  }

  /**
   * Say something now.
   * @param {SpokenSentence[]} sentences
   */
  announce(sentences) {
    if (!sentences.length) return;
    this.announcedAt = performance.now();
    this.from = this.time;
    this.line.textContent = inText(sentences);
  }

  /** Say how a motion begins, of another toy or the same one again. @param {Motion} motion */
  begin(motion) {
    clearTimeout(this.timer);
    this.before = null;
    this.show(motion);
    this.from = this.since = 0;
    this.last = null;
    this.describe(0);
    if (this.isPlaying) this.announce([startSentence(motion)]);
  }

  /**
   * Follow a run of other parameters, and say which.
   * @param {Motion} motion
   */
  replace(motion) {
    if (!this.motion) {
      this.begin(motion);
      return;
    }
    this.noteChange();
    this.show(motion);
    this.last = null;
    this.describe(this.time);
  }

  /** A toy on the move has another parameter from now on, which is said. */
  turned() {
    if (!this.motion) return;
    this.since = this.time;
    this.noteChange();
  }

  /** Say which options change now, once they have settled. */
  noteChange() {
    this.before ??= this.motion?.about.options ?? null;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.announceChange(), SETTLE);
  }

  announceChange() {
    const { before, motion } = this;
    this.before = null;
    if (!before || !motion) return;
    const now = motion.about.options;
    const names = Object.keys(now).filter((name) => JSON.stringify(now[name]) !== JSON.stringify(before[name]));
    const isOther = names.length > MOST_CHANGES || now.system !== before.system;
    this.announce(isOther ? [startSentence(motion)]
      : names.flatMap((name) => this.changed(name, before[name], now[name])));
  }

  /**
   * Sentences on a changed option, none if it is no number.
   * @param {string} option
   * @param {unknown} before
   * @param {unknown} now
   */
  changed(option, before, now) {
    const name = this.nameOf(option);
    if (!name || typeof before !== "number" || typeof now !== "number") return [];
    return [{ name: now > before ? "moreOf" : "lessOf", values: { name } }];
  }

  /**
   * Follow the motion to an instant.
   * @param {number} time
   * @param {boolean} isPlaying
   */
  move(time, isPlaying) {
    const { motion } = this;
    if (!motion) return;
    const begins = isPlaying && !this.isPlaying;
    const ends = !isPlaying && this.isPlaying;
    this.isPlaying = isPlaying;
    const isBack = time < this.time;
    if (isBack) [this.since, this.last] = [0, null];
    this.time = time;
    if (ends) this.pause();
    if (!isPlaying) return;
    if (begins || isBack) this.from = time < BEGINNING ? 0 : time;
    if (isBack) {
      // What was said is not yet true again.
      this.line.textContent = "";
      this.announcedAt = performance.now();
    }
    if (begins && time < BEGINNING) this.announce([startSentence(motion)]);
    else if (performance.now() - this.announcedAt > GAP) this.follow();
  }

  /** Say what happened since the last time, if that is worth saying. */
  follow() {
    const { time } = this;
    this.onDescribe();
    const next = bestSentence(this.log, this.from, time, this.since);
    const isNew = next && isNews(next, this.last);
    this.announcedAt = performance.now();
    this.from = time;
    if (!isNew) return;
    this.last = next;
    this.announce([next]);
  }

  /** Say where everything stands. */
  pause() {
    const { motion, time } = this;
    if (!motion) return;
    this.describe(time);
    this.announce([{ name: "pausedAt", values: { time: time.toFixed(2) } }, ...placesOf(motion, time)]);
  }

  /** Say what happens now, whether it was said before or not. */
  answer() {
    const { motion, time } = this;
    if (!motion) return;
    const now = bestSentence(this.log, time - GAP / 1000, time, this.since);
    this.describe(time);
    this.announce([startSentence(motion), ...(now ? [now] : []), ...placesOf(motion, time)]);
  }

  /**
   * Describe what the stage shows at an instant.
   * @param {number} time
   */
  describe(time) {
    const { motion } = this;
    if (!motion) return;
    this.about.textContent = inText([startSentence(motion), ...placesOf(motion, time)]);
    this.onDescribe();
  }

  /** Stop waiting. */
  end() {
    clearTimeout(this.timer);
  }
}
