/** Live: the toy runs in real time while hands change everything. */

import { followDrag } from "../shared/drag.js";
import { slackText } from "../shared/hang.js";
import { startKernels } from "../kernels/load.js";
import { READ_EVERY } from "../shared/clock.js";
import { beforePrint } from "../shared/dom.js";
import { followKeys } from "../shared/keys.js";
import { textOf, withLaws } from "../shared/laws.js";
import { whose } from "../shared/panels.js";
import { withControls, withSuspension } from "../live/address.js";
import { fit, makeKnobs } from "../live/controls.js";
import { cosineOf } from "../live/drive.js";
import { Keeper } from "../live/keeper.js";
import { LiveMotion } from "../live/motion.js";
import { Pace } from "../live/pace.js";
import { layOut, makeParts, takeKeys } from "../live/parts.js";
import { Shake } from "../live/shake.js";
import { Toy } from "../live/toy.js";
import { Watch } from "../live/watch.js";
import { specify } from "../model/case.js";
import { inPagesWords } from "../model/words.js";
import { sentence, waysOn } from "../shared/reading.js";
import { presetField } from "../shared/presets.js";
import { Scene } from "../shared/scene.js";
import { fromBottom } from "../shared/motion.js";
import { Senses } from "../shared/senses.js";
import { withOptions } from "../shared/links.js";
import { FIRST_OF_LIVE, OPTIONS_OF_LIVE } from "../shared/state.js";
import { DEGREE } from "../shared/units.js";
import { t, tr } from "../strings.js";

/** @typedef {import("../main.js").Page} Page */
/** @typedef {import("../shared/motion.js").Ball} Ball */

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

/**
 * Return whether two cases differ in nothing but what the controls change.
 * @param {import("../model/case.js").Case} one
 * @param {import("../model/case.js").Case} other
 */
function isSteered(one, other) {
  const rest = (/** @type {import("../model/case.js").Case} */ { system, angles, velocities, distances }) =>
    JSON.stringify([system.kind, system.gravity, angles, velocities, distances, system.suspension,
      system.string_restitution, system.drag_frame,
      system.balls.map((ball) => ({ ...ball, damping: 0 }))]);
  return rest(one) === rest(other);
}

export class LiveView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    this.shown = false;
    this.paused = matchMedia("(prefers-reduced-motion: reduce)").matches;
    /** @type {Toy | null} */
    this.toy = null;
    /** @type {LiveMotion | null} */
    this.motion = null;
    this.pace = new Pace();
    this.signature = "";
    this.dirty = false;
    this.readAt = 0;
    this.preset = presetField(page);
    /** The largest angle since the start, and that at the start [rad]. */
    this.highest = 0;
    this.begun = 0;
    /** Whether the headline says that the balls hang still. */
    this.saysStill = false;
    this.keeper = new Keeper(page, () => this.toy);
    this.shake = new Shake(() => this.toy, () => this.showShake());
    this.knobs = makeKnobs(page.registry, (name, _, value) => this.take(name, Number(value)));
    this.parts = makeParts(RATIOS, {
      pause: () => this.pause(),
      push: () => this.push(),
      restart: () => this.restart(),
      high: () => this.ratio(RATIOS.high),
      low: () => this.ratio(RATIOS.low),
      speed: (times) => { this.pace.speed = times; },
      shake: () => void this.shake.toggle(),
      hang: (kind) => page.store.set({ options: withSuspension(page.store.state.options, kind) }),
    });
    this.showPause();
    this.showShake();
    this.senses = new Senses(this.parts.canvas,
      () => [{ title: t("keysHere"), actions: this.actions() }]);
    this.senses.narrator.nameOf = (name) => this.knobs.inWords().options[name]?.label;
    this.root = layOut(this.parts, this.keeper, this.preset, this.knobs.root, this.senses);
    this.scene = new Scene(this.parts.canvas);
    this.watch = new Watch(this.parts.angle, this.parts.energy);
    this.senses.narrator.onDescribe = () => this.watch.describe();
    const lead = (/** @type {Ball} */ ball, /** @type {number} */ angle) =>
      this.toy?.hold({ ball: ball.row, angle });
    followDrag(this.scene, { lead, drop: () => this.toy?.hold(null),
      grab: (ball) => lead(ball, this.toy?.angles[ball.row] ?? 0), lift: (height) => this.shake.drag(height) });
    followKeys(this.root, this.actions());
    document.addEventListener("visibilitychange", () => this.returnToView());
    this.draw = this.draw.bind(this);
    /** @type {(() => void)[]} what ends listening */
    this.releases = [];
  }

  show() {
    this.shown = true;
    // Elsewhere on the page arrows scroll.
    const anywhere = Object.entries(this.actions()).filter(([key]) => !key.startsWith("Arrow"));
    this.releases.push(followKeys(document, Object.fromEntries(anywhere)), beforePrint(() => this.paused || this.pause()),
      this.page.store.subscribe((_, changed) => {
        if (changed !== "extra" && changed !== "view" && this.wish() !== this.signature)
          void this.begin(changed === "address" ? this.toy : null);
      }));
    if (this.wish() !== this.signature || !this.toy) void this.begin();
    this.pace.rest();
    takeKeys(this.parts.canvas);
    requestAnimationFrame(this.draw);
  }

  hide() {
    this.shown = false;
    for (const release of this.releases.splice(0)) release();
    this.keeper.finish();
    this.shake.end();
  }

  /** The run in the address, as a text to compare. */
  wish() {
    const { scenario, options } = this.page.store.state;
    return JSON.stringify([scenario, options]);
  }

  /**
   * Begin with what the address asks for, or steer a toy to it that differs in its controls alone.
   * @param {Toy | null} [running]
   */
  async begin(running = null) {
    this.signature = this.wish();
    const { signature } = this;
    if (!running) this.keeper.finish();
    this.toy = running;
    try {
      const each = await specify(this.page.registry, this.request());
      if (running && isSteered(running.case, each)) this.steer(running, each);
      else {
        const kernels = await startKernels(each.kernels.name);
        if (signature !== this.signature) return;
        this.keeper.finish();
        this.start(new Toy(kernels, each, cosineOf(each)));
      }
      this.say(this.page.registry.drives[each.drive.kind].sinusoidal ? "" : t("liveCosine"));
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (signature === this.signature) this.refuse(error);
    }
  }

  /**
   * Give a running toy the controls of a case, as if its sliders were moved there.
   * @param {Toy} toy
   * @param {import("../model/case.js").Case} each
   */
  steer(toy, each) {
    const { amplitude, frequency } = cosineOf(each);
    const { balls: [{ damping }], restitution } = each.system;
    const values = { drive_amplitude: amplitude, drive_frequency: frequency, damping, restitution };
    toy.set(Object.fromEntries(Object.entries(values).filter(([name]) => name in toy.controls)));
    for (const name of Object.keys(toy.controls)) this.knobs.all[name]?.show(toy.controls[name]);
    this.showRatio();
    this.rescale();
    this.dirty = true;
  }

  /** Return a picture of the stage. */
  async picture() {
    const { captionOf, stagePicture } = await import("../shared/picture.js");
    const { scenario } = this.page.store.state;
    return stagePicture(this.scene, { caption: captionOf(this.toy?.controls ?? {}),
      title: this.page.registry.scenarios[scenario ?? FIRST_OF_LIVE]?.title ?? t("view_live") });
  }

  /** The scenario and the options to run. */
  request() {
    const { registry, store } = this.page;
    let { scenario, options } = store.state;
    const isFirst = !scenario && !options.system;
    if (isFirst) {
      scenario = FIRST_OF_LIVE;
      if ((options.drive ?? OPTIONS_OF_LIVE.drive) === OPTIONS_OF_LIVE.drive)
        options = withOptions(OPTIONS_OF_LIVE, options);
    }
    if (scenario && options.system)
      options = withLaws(registry, options, {}, options.system, options.drive ?? "fixed_pivot");
    this.saysStill = isFirst && Object.keys(store.state.options).length === 0;
    this.preset.show(isFirst ? null : scenario, this.saysStill ? t("liveFirst") : "");
    return { scenario, options };
  }

  /** @param {Toy} toy */
  start(toy) {
    this.toy = toy;
    this.highest = this.begun = Math.max(...toy.angles.map(fromBottom));
    this.motion = new LiveMotion(toy, this.watch.history);
    fit(this.knobs, toy);
    this.knobs.explain(toy.system.naturalFrequency);
    this.parts.hang.value = toy.system.suspension;
    this.parts.hang.disabled = toy.system.linear;
    this.showRatio();
    const single = this.motion.balls.length < 2;
    this.root.classList.toggle("single", single);
    this.parts.energy.title.textContent = t("curveEnergy", { whose: whose(this.motion) });
    this.watch.begin(single);
    const { motion } = this;
    this.senses.loudest = LOUDEST * toy.system.naturalFrequency;
    this.senses.narrator.begin({ motion: /** @type {any} */ (motion), log: () => motion.log });
    this.rescale();
    this.shake.apply();
    this.pace.rest();
    this.dirty = true;
    this.allow(true);
    this.root.dataset.ready = "true";
  }

  /**
   * Enable or disable the buttons that move a toy.
   * @param {boolean} hasToy
   */
  allow(hasToy) {
    const { toggle, push, restart, high, low, shake } = this.parts;
    for (const button of [toggle, push, restart, high, low, shake, this.keeper.button])
      button.disabled = !hasToy;
  }

  /** Begin again, with the controls as they are. */
  restart() {
    this.keeper.finish();
    if (this.toy) this.start(this.toy.restarted());
  }

  /**
   * Take what was slid or typed.
   * @param {string} name
   * @param {number} value in SI units
   */
  take(name, value) {
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
   * Ask for a new value, and keep it in the address for the other views.
   * @param {string} name
   * @param {number} value in SI units
   */
  set(name, value) {
    const { registry, store } = this.page;
    if (!this.toy) {
      // The value before made no toy; this one may.
      const option = registry.options[name];
      if (option) store.option(name, textOf(option, value));
      return;
    }
    // These are of the cosine.
    if (["drive_amplitude", "drive_frequency"].includes(name) && this.shake.isOn) this.shake.end();
    this.senses.narrator.turned(name, this.toy.controls[name], value);
    this.toy.set({ [name]: value });
    this.dirty = true;
    if (name === "drive_amplitude") this.rescale();
    const options = withControls(registry, store.state.options, this.toy.system.kind,
      this.toy.controls, name);
    const scenario = store.state.scenario ?? (options.system ? null : FIRST_OF_LIVE);
    this.signature = JSON.stringify([scenario, options]);
    store.set({ scenario, options });
  }

  rescale() {
    if (!this.motion || !this.toy) return;
    this.motion.reach = this.toy.controls.drive_amplitude;
    this.scene.show(/** @type {any} */ (this.motion));
  }

  /**
   * Move the toy on, unless it is paused.
   * @param {number} now in ms
   */
  move(now) {
    const { toy, motion } = this;
    if (this.paused || !toy || !motion) return;
    try {
      this.pace.move(toy, now, () => {
        motion.follow();
        this.highest = Math.max(this.highest, ...toy.angles.map(fromBottom));
        const clacks = toy.clack > SOFTEST;
        this.watch.add(motion, clacks);
        if (clacks) this.scene.flash(motion.pose(), toy.clack);
        this.scene.ring(motion.pose(), motion.pulled.splice(0));
        toy.clack = 0;
        this.dirty = true;
      });
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      // The memory that it computed in may be spoiled: begin in a new one.
      void this.begin().then(() => {
        this.say(t("liveFault", { text: tr(error.message) }));
      });
    }
  }

  /**
   * Move the toy on and draw it, once for each picture of the screen.
   * @param {number} now in ms
   */
  draw(now) {
    if (!this.shown) return;
    requestAnimationFrame(this.draw);
    this.move(now);
    if (this.toy) this.senses.move(this.toy.time, !this.paused, this.pace.speed);
    if (!this.dirty || !this.motion || !this.toy) return;
    this.dirty = false;
    const { toy, motion, pace } = this;
    motion.rise(this.watch.largest());
    this.scene.time = toy.time;
    this.scene.draw();
    this.watch.draw(this.paused, this.parts.more.open);
    if (!this.paused && now - this.readAt < READ_EVERY) return;
    this.readAt = now;
    this.watch.read(motion, this.paused ? 0 : (pace.speed * READ_EVERY) / 1000);
    const text = toy.isShaken ? "liveReadoutShaken"
      : motion.balls.length > 1 ? "liveReadout" : "liveReadoutOne";
    const ratio = toy.controls.drive_frequency / toy.system.naturalFrequency;
    this.parts.status.textContent = t(text, {
      time: toy.time.toFixed(1), count: toy.contacts, ratio: ratio.toFixed(3),
    }) + slackText(motion, toy.time) + (pace.share < SLOW ? t("liveSlow", { share: (pace.share * pace.speed).toFixed(2) }) : "");
    this.preset.told.textContent = t("highest", { angle: Math.round(this.highest / DEGREE) });
    if (this.saysStill && this.highest > this.begun + DEGREE) {
      this.saysStill = false;
      this.preset.show(null);
    }
    this.showRatio();
    this.keeper.show();
    this.shake.watch();
  }

  /** Show what shakes the pivot now. */
  showShake() {
    this.parts.shake.setAttribute("aria-pressed", String(this.shake.isOn));
    if (this.shown) this.page.messages.say("shake", this.shake.text, { stays: true });
    if (!this.toy?.isShaken) this.rescale();
  }

  showRatio() {
    const { toy } = this;
    if (!toy) return;
    const ratio = toy.controls.drive_frequency / toy.system.naturalFrequency;
    this.knobs.all.frequency_ratio.read(ratio.toFixed(3), true);
    for (const name of /** @type {("high" | "low")[]} */ (["high", "low"]))
      this.parts[name].setAttribute("aria-pressed", String(Math.abs(ratio - RATIOS[name]) < 2e-3));
  }

  pause() {
    this.paused = !this.paused;
    if (this.paused && this.motion) this.watch.read(this.motion, 0);
    this.dirty = true;
    this.pace.rest();
    this.showPause();
  }

  showPause() {
    this.parts.toggle.textContent = t(this.paused ? "play" : "pause");
  }

  /** Tell that the toy stood still while its tab was in the background. */
  returnToView() {
    this.pace.rest();
    if (this.shown && !this.paused && !document.hidden)
      this.page.messages.say("hidden", t("liveHidden"));
  }

  push() {
    this.toy?.push(PUSH * this.toy.system.naturalFrequency);
  }

  /** @param {number} ratio */
  ratio(ratio) {
    if (this.toy) this.take("frequency_ratio", ratio);
  }

  /** The action of each key. @returns {import("../shared/keys.js").Actions} */
  actions() {
    const turn = (/** @type {string} */ name, /** @type {number} */ way) =>
      () => this.knobs.all[name]?.turn(way);
    return {
      " ": { text: "keyPlay", act: () => this.pause() },
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
      c: { text: "keyRecord", act: () => this.keeper.toggle() },
      1: { text: "keyHigh", act: () => this.ratio(RATIOS.high) },
      2: { text: "keyLow", act: () => this.ratio(RATIOS.low) },
      ...this.senses.actions(),
    };
  }

  /**
   * Show why there is no toy.
   * @param {Error} error
   */
  refuse(error) {
    const registry = this.knobs.inWords();
    this.knobs.error(...inPagesWords(registry, error));
    this.say(sentence(registry, error), waysOn(this.page, error), true);
    this.allow(false);
  }

  /**
   * Say something about the toy on show, and offer what can be done about it.
   * @param {string} text
   * @param {import("../shared/messages.js").Action[]} [actions]
   * @param {boolean} [isBad] whether something was refused
   */
  say(text, actions, isBad) {
    if (this.shown) this.page.messages.say("toy", text, { stays: true, actions, isBad });
  }
}
