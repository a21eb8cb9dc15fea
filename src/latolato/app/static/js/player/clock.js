/** The clock of a player, the one place that keeps the instant, and the menu of its speeds. */

import { t } from "../strings.js";
import { el, freshId } from "../page/dom.js";

// After a pause of the browser, such as a background tab, the clock goes on where it was.
const LONGEST_FRAME = 0.1; // s
// While it plays, texts follow at this rate and all at once; pictures at every instant.
const READ_EVERY = 100; // ms
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];

export class Clock {
  constructor() {
    this.time = 0;
    this.end = 1;
    this.speed = 1;
    this.looping = true;
    this.playing = false;
    /** What moves the time on in place of this clock: returns the instant of a picture at so many ms of the
     * browser. Nobody goes back in what it leads through. @type {((now: number) => number) | null} */
    this.lead = null;
    /** Whether this instant is one that texts show. */
    this.isRead = true;
    this.readAt = -Infinity;
    this.last = 0;
    this.frame = 0;
    /** @type {((time: number, clock: Clock) => void)[]} */
    this.listeners = [];
    this.step = this.step.bind(this);
  }

  /**
   * Call a function at every new instant; returns what ends that.
   * @param {(time: number, clock: Clock) => void} listener
   */
  subscribe(listener) {
    this.listeners.push(listener);
    return () => { this.listeners = this.listeners.filter((each) => each !== listener); };
  }

  play() {
    if (this.playing) return;
    if (this.time >= this.end && !this.lead) this.time = 0;
    this.playing = true;
    this.last = 0;
    this.frame = requestAnimationFrame(this.step);
    this.notify();
  }

  pause() {
    this.playing = false;
    cancelAnimationFrame(this.frame);
    this.notify();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  /**
   * Move to an instant.
   * @param {number} time
   */
  seek(time) {
    if (this.lead) return;
    this.time = Math.min(Math.max(time, 0), this.end);
    this.notify();
  }

  /** @param {number} now of the browser, in ms */
  step(now) {
    if (!this.playing) return;
    if (this.lead) {
      this.time = this.lead(now);
      this.notify();
      if (this.playing) this.frame = requestAnimationFrame(this.step);
      return;
    }
    const passed = this.last ? Math.min((now - this.last) / 1000, LONGEST_FRAME) : 0;
    this.last = now;
    this.advance(passed);
    if (this.playing) this.frame = requestAnimationFrame(this.step);
  }

  /** @param {number} passed s of real time */
  advance(passed) {
    let time = this.time + passed * this.speed;
    if (time >= this.end) {
      if (this.looping && this.end > 0) time %= this.end;
      else {
        time = this.end;
        this.playing = false;
      }
    }
    this.time = time;
    this.notify();
  }

  /** How far what texts show may be behind [s of the run]. */
  get lag() {
    return this.playing ? (this.speed * READ_EVERY) / 1000 : 0;
  }

  notify() {
    const now = performance.now();
    this.isRead = !this.playing || now - this.readAt >= READ_EVERY;
    if (this.isRead) this.readAt = now;
    for (const listener of this.listeners) listener(this.time, this);
  }
}

/**
 * Return a label and a menu of speeds up to the fastest one.
 * @param {number} fastest
 * @param {(speed: number) => void} [choose] called with a speed that was chosen
 * @returns {[HTMLLabelElement, HTMLSelectElement]}
 */
export function speedMenu(fastest, choose = () => {}) {
  const id = freshId();
  const menu = el("select", { id, on: { change: () => choose(Number(menu.value)) } },
    ...SPEEDS.filter((speed) => speed <= fastest).map((speed) =>
      el("option", { value: String(speed), selected: speed === 1 }, t("speedText", { speed }))));
  return [el("label", { for: id }, t("speed")), menu];
}
