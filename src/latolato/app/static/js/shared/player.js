/** The player: animation, angles over time, transport and, when asked for, more of one run. */

import { t } from "../strings.js";
import { Clack } from "./clack.js";
import { Clock } from "./clock.js";
import { el, freshId } from "./dom.js";
import { followKeys } from "./keys.js";
import { MoreCurves } from "./more.js";
import { range, Scene } from "./scene.js";
import { Timeline } from "./timeline.js";

/** @typedef {import("./motion.js").Motion} Motion */

const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
// Text and slider of the instant follow at this rate; the pictures at every frame.
const READ_EVERY = 100; // ms

export class Player {
  /**
   * @param {HTMLElement} root
   */
  constructor(root) {
    this.clock = new Clock();
    this.root = root;
    /** @type {Motion | null} */
    this.motion = null;
    /** @type {Motion | null} */
    this.pinned = null;
    this.readAt = 0;
    const canvas = el("canvas", { class: "scene", role: "img", "aria-label": t("animation") });
    this.clack = new Clack();
    this.timeline = new Timeline(this.clock);
    this.more = new MoreCurves(this.clock, this.curves);
    /** What stands on the stage: buttons above, messages below. */
    this.tools = el("div", { class: "stage-tools" }, ...this.makeSwitches());
    this.messages = el("div", { class: "stage-messages" });
    this.stage = el("div", { class: "stage" }, canvas, this.tools, this.messages);
    this.bench = el("div", { class: "bench" }, this.stage,
      el("div", { class: "panel" }, this.timeline.root, this.makeTransport()));
    root.append(this.bench, this.more.root);
    this.scene = new Scene(canvas);
    this.scene.onContact = (k) => {
      const { arrays } = /** @type {Motion} */ (this.motion).block;
      if (arrays.contact_kind[k] > 1) return;
      this.clack.sound(Math.abs(arrays.angular_velocity_before[k]) / this.fastest);
    };
    this.fastest = 1;
    this.curves.onSpan = (from, to) => {
      this.timeline.mark();
      this.more.setSpan(from, to);
    };
    this.clock.subscribe((time) => this.move(time));
    /** @type {Record<string, () => void>} what each key does */
    this.actions = { " ": () => this.clock.toggle(), ",": () => this.stepBy(-1),
      ".": () => this.stepBy(1) };
    followKeys(root, this.actions);
  }

  /** The angles over time. */
  get curves() {
    return this.timeline.curves;
  }

  makeSwitches() {
    const toggle = (/** @type {string} */ text, /** @type {string} */ hint,
      /** @type {(is: boolean) => void} */ change) => {
      const box = el("input", { type: "checkbox", on: { change: () => change(box.checked) } });
      return el("label", { class: "check", title: t(hint) }, box, t(text));
    };
    return [
      toggle("sound", "soundHint", (is) => { this.clack.on = is; }),
      toggle("arrows", "arrowsHint", (is) => {
        this.scene.arrows = is;
        this.scene.draw();
      }),
    ];
  }

  makeTransport() {
    const id = freshId();
    this.button = el("button", { type: "button", class: "play", on: { click: () => this.clock.toggle() } },
      t("play"));
    this.timeText = el("output", { class: "time" });
    this.speed = el("select", { id, on: { change: () => {
      this.clock.speed = Number(this.speed.value);
    } } }, ...SPEEDS.map((s) => el("option", { value: String(s), selected: s === 1 },
      t("speedText", { speed: s }))));
    this.loop = el("input", { type: "checkbox", checked: true, on: { change: () => {
      this.clock.looping = this.loop.checked;
    } } });
    return el("div", { class: "transport row" }, this.button,
      el("button", { type: "button", class: "plain step", "aria-label": t("stepBack"),
        on: { click: () => this.stepBy(-1) } }, "◂"),
      el("button", { type: "button", class: "plain step", "aria-label": t("stepForward"),
        on: { click: () => this.stepBy(1) } }, "▸"),
      this.timeText, this.timeline.toggles,
      el("span", { class: "check" }, el("label", { for: id }, t("speed")), this.speed),
      el("label", { class: "check" }, this.loop, t("loop")));
  }

  /**
   * Show a run, and keep the instant if it has it.
   * @param {Motion} motion
   */
  show(motion) {
    this.motion = motion;
    this.clock.end = motion.end;
    if (this.clock.time > motion.end) this.clock.time = 0;
    this.scene.show(motion);
    const [slow, fast] = range(motion.block.arrays.angular_velocity_before ?? []);
    this.fastest = Math.max(-slow, fast, 1e-9);
    this.timeline.show(motion, this.pinned);
    this.more.show(motion, this.pinned);
    this.move(this.clock.time);
  }

  /** Begin at the start of the run, with the curve that follows the clock. */
  restart() {
    this.clock.time = 0;
    this.curves.follows = true;
  }

  /** Keep the run on show behind the next ones, or let it go. */
  togglePin() {
    this.pinned = this.pinned ? null : this.motion;
    this.scene.pinned = this.pinned;
    this.scene.draw();
    if (this.motion) {
      this.timeline.show(this.motion, this.pinned);
      this.more.show(this.motion, this.pinned);
    }
    return this.pinned !== null;
  }

  /** @param {number} steps */
  stepBy(steps) {
    const motion = this.motion;
    if (!motion) return;
    this.clock.pause();
    this.clock.seek(this.clock.time + (steps * motion.end) / (motion.time.length - 1));
  }

  /** @param {number} time */
  move(time) {
    if (!this.motion) return;
    this.scene.move(time);
    this.timeline.move(time);
    this.more.move(time);
    const label = this.clock.playing ? t("pause") : t("play");
    if (this.button && this.button.textContent !== label) this.button.textContent = label;
    const now = performance.now();
    if (this.clock.playing && now - this.readAt < READ_EVERY) return;
    this.readAt = now;
    if (this.timeText) this.timeText.textContent = t("timeText", { time: time.toFixed(2) });
    this.timeline.tell(time);
  }

  destroy() {
    this.clock.pause();
    this.clack.close();
    this.curves.destroy();
    this.more.destroy();
    this.scene.release();
  }
}
