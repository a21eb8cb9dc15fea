/** The hand that holds a toy: it moves in real time while pointers, keys and sensors change everything. */

import { startKernels } from "../kernels/load.js";
import { resolvedOf } from "../model/run_block.js";
import { specify } from "../model/case.js";
import { el } from "../page/dom.js";
import { followDrag } from "../player/drag.js";
import { slackText } from "../player/hang.js";
import { textOf, textsOf } from "../page/option_texts.js";
import { before } from "../player/motion.js";
import { FIRST, HELD, PLAYED } from "../page/state.js";
import { t } from "../strings.js";
import { withControls } from "./held_options.js";
import { fit, KEYS } from "./held_knobs.js";
import { cosineOf } from "./drive.js";
import { GrowingMotion } from "./growing_motion.js";
import { FrameLoop } from "./frame_loop.js";
import { Shake } from "./shake.js";
import { Toy } from "./toy.js";

/** @typedef {import("../page/state.js").Page} Page */
/** @typedef {import("../page/block.js").Block} Block */
/** @typedef {import("../player/motion.js").MotionBall} MotionBall */
/** @typedef {import("../player/motion.js").Motion} Motion */
/**
 * What the view does for the hand: `request` returns the scenario and the options to run; `begun` shows
 * what a toy has begun with, in SI units; `refuse` says why there is none.
 * @typedef {{request: () => {scenario: string | null, options: Record<string, string>},
 *   begun: (options: Record<string, any>) => void, refuse: (error: Error) => void}} Owner
 */

// Fig. 12 of the paper: the fast stage lifts the balls off, the slow one swings them high.
const RATIOS = { high: 3.136, low: 2.389 };
// A push, in natural angular frequencies [rad/s].
const PUSH = 0.4;
// A softer contact is no clack to be seen [rad/s].
const SOFTEST = 0.1;
// Balls that meet this fast are as loud as it gets, in natural angular frequencies.
const LOUDEST = 3;
// A smaller share of real time is shown.
const SLOW = 0.95;
// A longer address is not understood by every server.
const LONGEST_ADDRESS = 6000;
// Drives whose cosine goes on from any instant of a run.
const STEADY = ["harmonic", "fixed_pivot"];

/**
 * Return the state of a run at its last sample up to an instant at which all balls are on their circles.
 * @param {Motion} motion
 * @param {number} time
 */
function stateOf(motion, time) {
  const balls = motion.balls.filter(({ row }, i) => i === 0 || row > 0);
  let i = Math.min(before(motion.time, time), motion.time.length - 2);
  while (i > 0 && balls.some((ball) => motion.isLoose(ball, i))) i -= 1;
  const of = (/** @type {string} */ name) =>
    balls.map(({ row }) => Number(motion.values(name, row)?.[i]));
  return { time: motion.time[i], angles: of("angle"), velocities: of("angular_velocity") };
}

/**
 * Return angles at which no balls overlap: those of a run on show may be off by rounding.
 * @param {number[]} angles
 * @param {import("../model/laws.js").System} system
 */
function apart(angles, { contacts, low, high }) {
  if (!contacts) return angles;
  const within = (/** @type {number} */ value) => Math.min(Math.max(value, low), high);
  if (angles.length === 1) return angles.map(within);
  const [right, left] = angles;
  const missing = within(right - left) - (right - left);
  return [right + 0.5 * missing, left - 0.5 * missing];
}

export class Hand {
  /**
   * @param {Page} page
   * @param {import("../player/player.js").Player} player whose stage and clock it takes
   * @param {import("../page/knobs.js").Knobs} knobs
   * @param {Owner} owner
   */
  constructor(page, player, knobs, owner) {
    this.page = page;
    this.player = player;
    this.knobs = knobs;
    this.owner = owner;
    this.isOn = false;
    /** @type {Toy | null} */
    this.toy = null;
    /** @type {GrowingMotion | null} */
    this.motion = null;
    /** What was kept and no address describes, by what addresses call it. @type {Map<string, Block>} */
    this.played = new Map();
    this.signature = "";
    this.pace = new FrameLoop();
    this.shake = new Shake(() => this.toy, () => this.showShake());
    const button = (/** @type {string} */ name, /** @type {string} */ key, /** @type {() => void} */ click) =>
      el("button", { type: "button", on: { click } }, t(name), el("kbd", { "aria-hidden": "true" }, key));
    const trick = (/** @type {"high" | "low"} */ name, /** @type {string} */ text, /** @type {string} */ key) =>
      el("button", { type: "button", on: { click: () => this.ratio(RATIOS[name]) } },
        t(text, { ratio: RATIOS[name] }), el("kbd", { "aria-hidden": "true" }, key));
    this.parts = {
      push: button("push", "P", () => this.push()),
      restart: button("restart", "R", () => this.restart()),
      shake: button("shakeIt", "S", () => void this.shake.toggle()),
      keep: button("keepMinute", "C", () => this.keep()),
      high: trick("high", "highFrequency", "1"),
      low: trick("low", "lowFrequency", "2"),
    };
    const { push, restart, shake, keep, high, low } = this.parts;
    /** What a hand can do, in the row of the transport. */
    this.tools = el("span", { class: "row of-hand" }, push, restart, shake, keep);
    this.readout = el("p", { class: "readout of-hand" });
    this.hint = el("p", { class: "hint of-hand", id: "hand-keys" }, t("handKeys"));
    this.trick = el("section", { class: "card trick of-hand" }, el("h2", {}, t("trick")),
      el("div", { class: "row" }, high, el("span", {}, t("trickThen")), low),
      el("details", { class: "about" }, el("summary", {}, t("trickWhy")), el("p", {}, t("trickHint")),
        el("ol", {}, el("li", {}, t("trickStep1")), el("li", {}, t("trickStep2"))),
        el("p", { class: "hint" }, t("trickMore"))));
    const lead = (/** @type {MotionBall} */ ball, /** @type {number} */ angle) =>
      this.toy?.hold({ ball: ball.row, angle });
    followDrag(player.scene, { isOn: () => this.isOn, lead, drop: () => this.toy?.hold(null),
      grab: (ball) => lead(ball, this.toy?.angles[ball.row] ?? 0), lift: (height) => this.shake.drag(height) });
    player.clock.subscribe((_, { playing, isRead }) => {
      if (!playing) this.pace.rest();
      if (this.isOn && isRead) this.read();
    });
    document.addEventListener("visibilitychange", () => this.returnToView());
  }

  /**
   * Take the toy, where the run on show has it.
   * @param {boolean} isPressed whether somebody pressed the button, and not an address or a story asks for it
   */
  async take(isPressed) {
    const { player } = this;
    this.isOn = true;
    const { motion, clock: { time } } = player;
    const from = motion && !motion.grows ? stateOf(motion, time) : null;
    await this.begin(from);
    if (this.isOn) this.takeKeys(isPressed);
  }

  /** Let the toy go. */
  release() {
    this.isOn = false;
    this.shake.end();
    this.toy = this.motion = null;
    this.signature = "";
    this.say("");
    this.player.scene.canvas.classList.remove("grabbable", "unasked");
  }

  /** The run in the address, as a text to compare. */
  wish() {
    const { scenario, options } = this.page.store.state;
    return JSON.stringify([scenario, options]);
  }

  /**
   * Begin with what the address asks for, if that has changed.
   * @param {boolean} goesOn whether from where the balls are now
   */
  follow(goesOn) {
    const { toy } = this;
    if (this.wish() === this.signature) return;
    // A toy with a ball that has left its circle begins again at its start.
    void this.begin(goesOn && toy && !toy.state("is_slack").some(Number)
      ? { time: toy.time, angles: toy.angles, velocities: toy.velocities } : null);
  }

  /**
   * Begin with what the address asks for.
   * @param {{time: number, angles: number[], velocities: number[]} | null} [from] where a run on show, or the toy
   *   before, has as many balls
   */
  async begin(from = null) {
    this.signature = this.wish();
    const { signature } = this;
    this.toy = null;
    try {
      const each = await specify(this.page.registry, this.owner.request());
      const kernels = await startKernels(each.kernels.name);
      if (signature !== this.signature || !this.isOn) return;
      const cosine = cosineOf(each);
      this.start(from && STEADY.includes(each.drive.kind) && from.angles.length === each.angles.length
        ? new Toy(kernels, { ...each, angles: apart(from.angles, each.system), velocities: from.velocities, distances: [] },
          { ...cosine, phase: cosine.phase + cosine.frequency * from.time })
        : new Toy(kernels, each, cosine));
      this.owner.begun(resolvedOf(each));
      this.say(this.page.registry.drives[each.drive.kind].sinusoidal ? "" : t("handCosine"));
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (signature !== this.signature) return;
      this.owner.refuse(error);
      this.allow(false);
    }
  }

  /** @param {Toy} toy */
  start(toy) {
    const { knobs, player } = this;
    this.toy = toy;
    const motion = new GrowingMotion(toy);
    this.motion = motion;
    knobs.keys = KEYS;
    fit(knobs, toy);
    knobs.explain(toy.system.naturalFrequency);
    this.trick.hidden = motion.balls.length < 2;
    player.hold(motion, (now) => this.move(now), LOUDEST * toy.system.naturalFrequency);
    const { canvas } = player.scene;
    canvas.classList.add("grabbable");
    canvas.setAttribute("aria-label", t("handStage"));
    this.showRatio();
    this.shake.apply();
    this.pace.rest();
    this.allow(true);
    this.read();
  }

  /**
   * Enable or disable the buttons that move a toy.
   * @param {boolean} hasToy
   */
  allow(hasToy) {
    for (const button of Object.values(this.parts)) button.disabled = !hasToy;
  }

  /** Begin again as the run of the address begins, which has the controls as they are. */
  restart() {
    if (this.toy) void this.begin();
  }

  /**
   * Take what was slid or typed.
   * @param {string} name
   * @param {number} value in SI units
   */
  turn(name, value) {
    const { toy } = this;
    const isRatio = name === "frequency_ratio";
    const scale = isRatio && toy ? toy.system.naturalFrequency : 1;
    const control = isRatio ? "drive_frequency" : name;
    this.knobs.error(null);
    this.say("");
    this.set(control, value * scale);
    this.knobs.all[control].show(value * scale);
  }

  /**
   * Ask for a new value, and keep it in the address.
   * @param {string} name
   * @param {number} value in SI units
   */
  set(name, value) {
    const { registry, store } = this.page;
    if (!this.toy) {
      // The value before made no toy; this one may.
      if (registry.options[name]) store.option(name, textOf(registry, name, value));
      return;
    }
    // These are of the cosine.
    if (["drive_amplitude", "drive_frequency"].includes(name) && this.shake.isOn) this.shake.end();
    this.player.accessibility.liveRegion?.turned();
    this.toy.set({ [name]: value });
    if (name === "drive_amplitude") this.rescale();
    const options = withControls(registry, store.state.options, this.toy.system.kind,
      this.toy.controls, name);
    const scenario = store.state.scenario ?? (options.system ? null : FIRST);
    this.signature = JSON.stringify([scenario, options]);
    store.set({ scenario, options });
  }

  /** Show as much of the plane as the pivot needs. */
  rescale() {
    if (!this.motion || !this.toy) return;
    this.motion.reach = this.toy.controls.drive_amplitude;
    this.player.scene.draw();
  }

  /**
   * Move the toy on to a picture; returns its time [s].
   * @param {number} now in ms
   */
  move(now) {
    const { toy, motion, pace, player: { clock, scene } } = this;
    if (!toy || !motion) return clock.time;
    pace.speed = clock.speed;
    try {
      pace.move(toy, now, () => {
        motion.follow();
        if (toy.clack > SOFTEST) scene.flash(motion.pose(), toy.clack);
        toy.clack = 0;
      });
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      // The memory that it computed in may be spoiled: begin in a new one.
      void this.begin().then(() => this.say(t("handFault", { text: error.message })));
    }
    motion.rise();
    return toy.time;
  }

  /** Write what the toy does now. */
  read() {
    const { toy, motion, pace } = this;
    if (!toy || !motion) return;
    const text = toy.isShaken ? "handReadoutShaken"
      : motion.balls.length > 1 ? "handReadout" : "handReadoutOne";
    const ratio = toy.controls.drive_frequency / toy.system.naturalFrequency;
    this.readout.textContent = t(text, {
      time: toy.time.toFixed(1), count: toy.contacts, ratio: ratio.toFixed(3),
    }) + slackText(motion, toy.time) + (pace.share < SLOW ? t("handSlow", { share: (pace.share * pace.speed).toFixed(2) }) : "");
    this.showRatio();
    this.shake.watch();
  }

  /** Show what shakes the pivot now. */
  showShake() {
    this.parts.shake.setAttribute("aria-pressed", String(this.shake.isOn));
    this.page.messages.show("shake", this.shake.text, { stays: true });
    if (!this.toy?.isShaken) this.rescale();
  }

  showRatio() {
    const { toy } = this;
    if (!toy) return;
    const ratio = toy.controls.drive_frequency / toy.system.naturalFrequency;
    this.knobs.all.frequency_ratio?.read(ratio.toFixed(3), true);
    for (const name of /** @type {("high" | "low")[]} */ (["high", "low"]))
      this.parts[name].setAttribute("aria-pressed", String(Math.abs(ratio - RATIOS[name]) < 2e-3));
  }

  /** Show the last minute as a run like any other. */
  keep() {
    const { toy } = this;
    if (!toy) return;
    const kept = toy.minute.keep(toy.system);
    const again = kept.again();
    const block = kept.block(again);
    const options = kept.isRun(again) ? textsOf(this.page.registry, kept.options()) : null;
    const { store } = this.page;
    const { [HELD]: _, ...extra } = store.state.extra;
    if (options && new URLSearchParams(options).toString().length < LONGEST_ADDRESS) {
      store.set({ scenario: null, options, extra }, "preset");
      this.tellKept(block);
      return;
    }
    // No page that is loaded again gives this name to something else.
    const name = String(Date.now());
    this.played.set(name, block);
    store.set({ extra: { ...extra, [PLAYED]: name } }, "extra");
  }

  /**
   * Say what was kept, and whether it can be made again.
   * @param {Block} block
   */
  tellKept({ about, arrays: { time } }) {
    const { messages, store } = this.page;
    messages.showOfStep("kept", t("kept", { time: time[time.length - 1].toFixed(1), text: about.note }), store);
  }

  /** Tell that the toy stood still while its tab was in the background. */
  returnToView() {
    this.pace.rest();
    if (this.isOn && this.player.clock.playing && !document.hidden)
      this.page.messages.show("hidden", t("handHidden"));
  }

  push() {
    this.toy?.push(PUSH * this.toy.system.naturalFrequency);
  }

  /** @param {number} ratio */
  ratio(ratio) {
    if (this.toy) this.turn("frequency_ratio", ratio);
  }

  /**
   * Let arrow keys steer the toy, unless the focus is elsewhere on the page, as in a story. A frame shows
   * the focus as soon as somebody uses keys.
   * @param {boolean} isPressed whether the focus is on the button that was pressed
   */
  takeKeys(isPressed) {
    const { canvas } = this.player.scene;
    const { activeElement, body } = document;
    if (!isPressed && activeElement !== body && !activeElement?.closest("#views")) return;
    canvas.classList.add("unasked");
    const reveal = () => canvas.classList.remove("unasked");
    canvas.focus({ preventScroll: true });
    canvas.addEventListener("blur", reveal, { once: true });
    window.addEventListener("keydown", reveal, { once: true });
  }

  /** The action of each key. @returns {import("../page/keys.js").KeyActions} */
  actions() {
    const turn = (/** @type {string} */ name, /** @type {number} */ way) =>
      () => this.knobs.all[name]?.turn(way);
    return {
      ArrowUp: { text: "keyAmplitudeUp", act: turn("drive_amplitude", 1) },
      ArrowDown: { text: "keyAmplitudeDown", act: turn("drive_amplitude", -1) },
      ArrowRight: { text: "keyFrequencyUp", act: turn("drive_frequency", 1) },
      ArrowLeft: { text: "keyFrequencyDown", act: turn("drive_frequency", -1) },
      d: { text: "keyDampingUp", act: turn("damping", 1) },
      D: { text: "keyDampingDown", act: turn("damping", -1) },
      e: { text: "keyRestitutionUp", act: turn("restitution", 1) },
      E: { text: "keyRestitutionDown", act: turn("restitution", -1) },
      p: { text: "keyPush", act: () => this.push() },
      s: { text: "keyShake", act: () => void this.shake.toggle() },
      r: { text: "keyRestart", act: () => this.restart() },
      c: { text: "keyKeep", act: () => this.keep() },
      1: { text: "keyHigh", act: () => this.ratio(RATIOS.high) },
      2: { text: "keyLow", act: () => this.ratio(RATIOS.low) },
    };
  }

  /**
   * Say something about the toy on show.
   * @param {string} text
   */
  say(text) {
    this.page.messages.show("toy", text, { stays: true });
  }
}
