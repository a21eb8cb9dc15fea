/** When to say something about a motion: a sentence at a time, as fast as a person can follow. */

import { t } from "../strings.js";
import { bestSentence, isNews, placesOf, startOf } from "./describe.js";
import { el, freshId } from "../page/dom.js";

/** @typedef {import("./describe.js").SpokenSentence} SpokenSentence */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./events.js").Log} Log */
/** @typedef {{motion: Motion, log: () => Log}} LiveSource */

// Sentences follow each other by at least this time of the page.
const GAP = 3000; // ms
// A change is mentioned when nothing was changed for so long.
const SETTLE = 700; // ms
// More parameters change at once only where another motion is chosen.
const MOST_CHANGES = 2;

/** @param {SpokenSentence[]} sentences */
export const inText = (sentences) => sentences.map(({ name, values }) => t(name, values)).join(" ");

export class LiveRegion {
  /** @param {() => number} clock in ms */
  constructor(clock = () => performance.now()) {
    this.clock = clock;
    /** What screen readers read aloud when it changes. */
    this.line = el("p", { class: "narration unseen", "aria-live": "polite" });
    /** What the stage shows, where a reader looks for that. */
    this.about = el("p", { class: "unseen", id: freshId() });
    /** Called when the stage is described again, so that others are as well. */
    this.onDescribe = () => {};
    /** Returns what an option is called, if its changes are to be mentioned.
     * @type {(option: string) => string | undefined} */
    this.nameOf = () => undefined;
    /** @type {LiveSource | null} */
    this.source = null;
    this.isPlaying = false;
    this.time = 0;
    this.announcedAt = -Infinity;
    this.from = 0;
    this.since = 0;
    /** @type {SpokenSentence | null} */
    this.last = null;
    /** What was just changed, from which value to which. @type {Record<string, [number, number]>} */
    this.turns = {};
    /** The options of the run before a change that is not yet mentioned. @type {Record<string, any> | null} */
    this.before = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
  }

  /**
   * Say something now.
   * @param {SpokenSentence[]} sentences
   */
  announce(sentences) {
    if (!sentences.length) return;
    this.announcedAt = this.clock();
    this.from = this.time;
    this.line.textContent = inText(sentences);
  }

  /** Say how a motion begins, of another toy or the same one again. @param {LiveSource} source */
  begin(source) {
    clearTimeout(this.timer);
    this.before = null;
    this.turns = {};
    this.source = source;
    this.from = this.since = 0;
    this.last = null;
    this.describe(0);
    if (this.isPlaying) this.announce([startOf(source.motion)]);
  }

  /**
   * Follow a run of other parameters, and say which.
   * @param {LiveSource} source
   */
  replace(source) {
    if (!this.source) {
      this.begin(source);
      return;
    }
    this.before ??= this.source.motion.about.options;
    this.source = source;
    this.last = null;
    this.describe(this.time);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.announceChange(), SETTLE);
  }

  /** Say which parameter of the run is another one. */
  announceChange() {
    const { before, source } = this;
    this.before = null;
    if (!before || !source) return;
    const now = source.motion.about.options;
    const names = Object.keys(now).filter((name) => JSON.stringify(now[name]) !== JSON.stringify(before[name]));
    if (!names.length) return;
    const isOther = names.length > MOST_CHANGES || now.system !== before.system;
    this.announce(isOther ? [startOf(source.motion)] : this.changed(names[0], before[names[0]], now[names[0]]));
  }

  /**
   * Sentences on a changed option, none if it is no number.
   * @param {string} option
   * @param {unknown} before
   * @param {unknown} now
   */
  changed(option, before, now) {
    const name = this.nameOf(option);
    if (!name || typeof before !== "number" || typeof now !== "number" || now === before) return [];
    return [{ name: now > before ? "moreOf" : "lessOf", values: { name } }];
  }

  /**
   * Say that a toy on the move has another parameter from now on.
   * @param {string} name of an option
   * @param {number} before
   * @param {number} now
   */
  turned(name, before, now) {
    const { source, time } = this;
    if (!source) return;
    this.since = time;
    this.turns[name] = [this.turns[name]?.[0] ?? before, now];
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.announce(Object.entries(this.turns).flatMap(([each, ends]) => this.changed(each, ...ends)));
      this.turns = {};
    }, SETTLE);
  }

  /**
   * Follow the motion to an instant.
   * @param {number} time
   * @param {boolean} isPlaying
   */
  move(time, isPlaying) {
    const { source } = this;
    if (!source) return;
    const begins = isPlaying && !this.isPlaying;
    const ends = !isPlaying && this.isPlaying;
    this.isPlaying = isPlaying;
    if (time < this.time) [this.from, this.since, this.last] = [time, 0, null];
    this.time = time;
    if (ends) this.pause();
    if (begins) this.from = time;
    if (!isPlaying) return;
    if (begins && time < 1) this.announce([startOf(source.motion)]);
    else if (this.clock() - this.announcedAt > GAP) this.follow(source);
  }

  /** Say what happened since the last time, if that is worth saying. @param {LiveSource} source */
  follow(source) {
    const { time } = this;
    const next = bestSentence(source.log(), this.from, time, this.since);
    const isNew = next && isNews(next, this.last);
    this.announcedAt = this.clock();
    this.from = time;
    if (!isNew) return;
    this.last = next;
    this.announce([next]);
  }

  /** Say where everything stands. */
  pause() {
    const { source, time } = this;
    if (!source) return;
    this.describe(time);
    this.announce([{ name: "pausedAt", values: { time: time.toFixed(2) } }, ...placesOf(source.motion, time)]);
  }

  /** Say what happens now, whether it was said before or not. */
  answer() {
    const { source, time } = this;
    if (!source) return;
    const now = bestSentence(source.log(), time - GAP / 1000, time, this.since);
    this.describe(time);
    this.announce([startOf(source.motion), ...(now ? [now] : []), ...placesOf(source.motion, time)]);
  }

  /**
   * Describe what the stage shows at an instant.
   * @param {number} time
   */
  describe(time) {
    const { source } = this;
    if (!source) return;
    this.about.textContent = inText([startOf(source.motion), ...placesOf(source.motion, time)]);
    this.onDescribe();
  }

  /** Stop waiting. */
  end() {
    clearTimeout(this.timer);
  }
}
