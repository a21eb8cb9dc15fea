/** The player: animation, angles over time, transport and, when asked for, more of one run. */

import { t } from "../strings.js";
import { Clock, speedMenu } from "./clock.js";
import { el, tick } from "../page/dom.js";
import { sayOffline } from "../page/messages.js";
import { slackText } from "./hang.js";
import { followKeys } from "../page/keys.js";
import { range } from "./motion.js";
import { Scene } from "./scene.js";
import { Accessibility } from "./accessibility.js";
import { Start } from "./start.js";
import { Timeline } from "./timeline.js";

/** @typedef {import("./motion.js").Motion} Motion */

const FASTEST = 50;

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
    const canvas = el("canvas", { class: "scene", role: "img", "aria-label": t("animation") });
    this.timeline = new Timeline(this.clock);
    this.moreCurves = el("details", { class: "more-curves", on: { toggle: () => void this.openMore() } },
      el("summary", {}, t("moreCurves")));
    /** Made when its drawer is first opened. @type {import("./more_curves.js").MoreCurves | null} */
    this.more = null;
    this.accessibility = new Accessibility(canvas, () => [{ title: t("keysHere"), actions: this.keys() },
      ...(this.start.choose ? [{ title: t("keysOfStage"), actions: this.start.keys() }] : []),
      ...(this.clock.lead ? [] : [{ title: t("keysOfCurve"), actions: this.curves.actions }])]);
    this.accessibility.onDescribe = () => {
      if (this.motion?.grows) void this.curves.describe(this.motion);
    };
    /** What stands on the stage: buttons above, messages below. */
    this.tools = el("div", { class: "stage-tools" }, this.makeArrowsSwitch(), this.accessibility.toggle);
    this.messages = el("div", { class: "stage-messages" });
    this.stage = el("div", { class: "stage" }, canvas, this.tools, this.messages);
    this.bench = el("div", { class: "bench" }, this.stage,
      el("div", { class: "panel" }, this.timeline.root, this.makeTransport(), this.accessibility.root));
    root.append(this.bench, this.moreCurves);
    this.scene = new Scene(canvas);
    this.start = new Start(this.scene, this.clock);
    canvas.after(this.scene.legend, this.start.said);
    this.curves.held = () => this.scene.held;
    this.curves.onSpan = (from, to) => {
      this.timeline.mark();
      this.more?.setSpan(from, to);
    };
    this.clock.subscribe((time) => this.move(time));
    /** What a hand that holds the toy does at which key. @type {import("../page/keys.js").KeyActions} */
    this.heldActions = {};
    /** @type {import("../page/keys.js").KeyActions} */
    this.actions = {
      " ": { text: "keyPlay", act: () => this.clock.toggle() },
      ",": { text: "keyBack", act: () => this.stepBy(-1) },
      ".": { text: "keyOn", act: () => this.stepBy(1) },
      ...this.accessibility.actions(),
    };
    followKeys(root, this.actions);
  }

  /** The keys that do something now. @returns {import("../page/keys.js").KeyActions} */
  keys() {
    const { ",": back, ".": on, ...others } = this.actions;
    const { w, "?": help, ...first } = others;
    return this.clock.lead ? { ...first, ...this.heldActions, w, "?": help } : this.actions;
  }

  /** The angles over time. */
  get curves() {
    return this.timeline.curves;
  }

  makeArrowsSwitch() {
    const { root, box } = tick(t("arrows"), async () => {
      const arrows = await import("./arrows.js").catch(sayOffline);
      box.checked &&= arrows !== undefined;
      this.scene.showArrows(box.checked && arrows ? arrows : null);
    });
    root.title = t("arrowsHint");
    return root;
  }

  makeTransport() {
    this.button = el("button", { type: "button", class: "play", disabled: true, on: { click: () => this.clock.toggle() } },
      t("play"));
    this.timeText = el("output", { class: "time" });
    const speed = speedMenu(FASTEST, (chosen) => { this.clock.speed = chosen; });
    const loop = tick(t("loop"), (on) => { this.clock.looping = on; });
    loop.root.classList.add("of-run");
    this.loop = loop.box;
    this.loop.checked = true;
    return el("div", { class: "transport row" }, this.button,
      el("button", { type: "button", class: "plain step", "aria-label": t("stepBack"),
        on: { click: () => this.stepBy(-1) } }, "◂"),
      el("button", { type: "button", class: "plain step", "aria-label": t("stepForward"),
        on: { click: () => this.stepBy(1) } }, "▸"),
      this.timeText, this.timeline.toggles,
      el("span", { class: "check" }, ...speed),
      loop.root);
  }

  /** Fill the drawer of further curves when it is first opened. */
  async openMore() {
    if (this.more) return;
    const module = await import("./more_curves.js").catch(sayOffline);
    if (!module || this.more) return;
    this.more = new module.MoreCurves(this.moreCurves, this.clock, this.curves);
    this.showCurves();
  }

  /**
   * Show a motion that goes on by itself, as somebody holds the toy, until it is let go.
   * @param {any} motion that grows
   * @param {(now: number) => number} lead moves it on to a picture, and returns its instant
   * @param {number} loudest speed of a clack, as loud as it gets [rad/s]
   */
  hold(motion, lead, loudest) {
    const { clock, scene, accessibility } = this;
    this.take(motion);
    scene.pinned = null;
    this.root.classList.add("held");
    this.start.disable();
    [clock.lead, clock.time] = [lead, motion.end];
    scene.show(motion);
    accessibility.loudest = loudest;
    accessibility.follow(motion, true);
    this.showCurves();
    this.move(clock.time);
  }

  /** Show the curves of the motion, with those of a pinned run behind the ones of a run. */
  showCurves() {
    const { motion } = this;
    if (!motion) return;
    const pinned = motion.grows ? null : this.pinned;
    this.timeline.show(motion, pinned);
    this.more?.show(motion, pinned);
  }

  /** Leave the stage to the next run, which begins at its start. */
  letGo() {
    this.root.classList.remove("held");
    [this.clock.lead, this.clock.time] = [null, 0];
    this.take(null);
    this.accessibility.leave();
    this.scene.pinned = this.pinned;
  }

  /** @param {Motion | null} motion without one there is nothing to play */
  take(motion) {
    this.motion = motion;
    if (this.button) this.button.disabled = !motion;
  }

  /**
   * Show a run, and keep the instant if it has it.
   * @param {Motion} motion
   */
  show(motion) {
    this.take(motion);
    this.timeText?.classList.toggle("of-strings", motion.isString);
    this.clock.end = motion.end;
    if (this.clock.time > motion.end) this.clock.time = 0;
    this.scene.show(motion);
    const [slow, fast] = range(motion.block.arrays.angular_velocity_before ?? []);
    this.accessibility.loudest = 2 * Math.max(-slow, fast, 1e-9);
    this.accessibility.follow(motion);
    this.showCurves();
    this.move(this.clock.time);
    this.start.play();
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
    this.showCurves();
    return this.pinned !== null;
  }

  /** @param {number} steps */
  stepBy(steps) {
    const motion = this.motion;
    if (!motion || motion.grows) return;
    this.clock.pause();
    this.clock.seek(this.clock.time + (steps * motion.end) / (motion.time.length - 1));
  }

  /** @param {number} time */
  move(time) {
    if (!this.motion) return;
    this.scene.move(time);
    this.timeline.move(time);
    this.more?.move(time);
    this.accessibility.move(time, this.clock.playing, this.clock.speed);
    const label = this.clock.playing ? t("pause") : t("play");
    if (this.button && this.button.textContent !== label) this.button.textContent = label;
    if (!this.clock.isRead) return;
    if (this.timeText) this.timeText.textContent = t("timeText", { time: time.toFixed(this.clock.playing ? 1 : 2) }) + slackText(this.motion, time);
    this.timeline.update(time);
  }

  destroy() {
    this.clock.pause();
    this.accessibility.close();
    this.curves.destroy();
    this.more?.destroy();
    this.scene.release();
  }
}
