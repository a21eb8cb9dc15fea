/** Live: the toy runs in real time while hands change everything. */

import { Clack } from "../shared/clack.js";
import { startKernels } from "../kernels/load.js";
import { followKeys } from "../shared/keys.js";
import { textOf, withLaws } from "../shared/laws.js";
import { withControls } from "../live/address.js";
import { cosineOf, isByCosine } from "../live/drive.js";
import { followHand } from "../live/hand.js";
import { Keeper } from "../live/keeper.js";
import { KEYS, Knob } from "../live/knob.js";
import { LiveMotion } from "../live/motion.js";
import { Pace } from "../live/pace.js";
import { layOut, makeParts } from "../live/parts.js";
import { Toy } from "../live/toy.js";
import { Watch } from "../live/watch.js";
import { specify } from "../model/case.js";
import { inPagesWords } from "../model/words.js";
import { sentence, waysOn } from "../shared/reading.js";
import { presetField } from "../shared/presets.js";
import { Scene } from "../shared/scene.js";
import { t } from "../strings.js";

/** @typedef {import("../main.js").Page} Page */

// What is on show where the address says nothing. At the 30 mm that are assumed for Fig. 12 it is
// a matter of luck whether the resting balls lift off at the high frequency (9 of 60 instants of
// the change); from 32 mm on they always do (60 of 60, within 15 s).
const FIRST = "fig12";
const FIRST_OPTIONS = { drive_amplitude: "34 mm" };
const READ_EVERY = 100; // ms
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
// How far the sliders go: lengths, natural frequencies, and a share of what a toy takes.
const SLIDER = { drive_amplitude: 0.25, drive_frequency: 5, damping: 0.05 };

/**
 * Return whether two cases differ in nothing but what the controls change.
 * @param {import("../model/case.js").Case} one
 * @param {import("../model/case.js").Case} other
 */
function isSteered(one, other) {
  const rest = (/** @type {import("../model/case.js").Case} */ { system, angles, velocities }) =>
    JSON.stringify([system.kind, system.gravity, angles, velocities,
      system.balls.map((ball) => ({ ...ball, damping: 0 }))]);
  return rest(one) === rest(other);
}

export class LiveView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    this.shown = false;
    this.paused = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.calm = this.paused;
    /** @type {Toy | null} */
    this.toy = null;
    /** @type {LiveMotion | null} */
    this.motion = null;
    this.pace = new Pace();
    this.signature = "";
    this.dirty = false;
    this.readAt = 0;
    this.preset = presetField(page);
    this.keeper = new Keeper(page, () => this.toy);
    /** @type {Record<string, Knob>} */
    this.knobs = {};
    this.clack = new Clack();
    this.parts = makeParts(RATIOS, {
      sound: (on) => { this.clack.on = on; },
      pause: () => this.pause(),
      push: () => this.push(),
      restart: () => this.restart(),
      high: () => this.ratio(RATIOS.high),
      low: () => this.ratio(RATIOS.low),
      speed: (times) => { this.pace.speed = times; },
    });
    this.showPause();
    this.root = layOut(this.parts, this.keeper.button, this.keeper.result, this.preset.field);
    this.scene = new Scene(this.parts.canvas);
    this.watch = new Watch(this.parts.angle.canvas, this.parts.energy.canvas);
    followHand(this.parts.canvas, this.scene, () => this.motion,
      (aim) => this.toy?.hold(aim));
    followKeys(this.root, this.actions());
    document.addEventListener("visibilitychange", () => this.returnToView());
    this.draw = this.draw.bind(this);
    /** @type {() => void} */
    this.unsubscribe = () => {};
    this.unfollow = () => {};
  }

  show() {
    this.shown = true;
    this.unsubscribe = this.page.store.subscribe((_, changed) => {
      if (changed !== "extra" && changed !== "view" && this.wish() !== this.signature)
        void this.begin(changed === "address" ? this.toy : null);
    });
    if (this.wish() !== this.signature || !this.toy) void this.begin();
    this.pace.rest();
    this.parts.canvas.focus({ preventScroll: true });
    this.unfollow = followKeys(document, { " ": () => this.pause() });
    requestAnimationFrame(this.draw);
  }

  hide() {
    this.shown = false;
    this.unsubscribe();
    this.unfollow();
    this.keeper.finish();
  }

  /** Return what the address asks for, as a text to compare. */
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
        const kernels = await startKernels(each.system.angles === 2 ? "two" : "one");
        if (signature !== this.signature) return;
        this.keeper.finish();
        this.start(new Toy(kernels, each, cosineOf(each)));
      }
      this.say(isByCosine(each.drive.kind) ? "" : t("liveCosine"));
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
    for (const [name, knob] of Object.entries(this.knobs)) knob.show(toy.controls[name]);
    this.rescale();
    this.dirty = true;
  }

  /** Return a picture of the stage. */
  async picture() {
    const { captionOf, stagePicture } = await import("../shared/picture.js");
    const { scenario } = this.page.store.state;
    return stagePicture(this.scene, { caption: captionOf(this.toy?.controls ?? {}),
      title: this.page.registry.scenarios[scenario ?? FIRST]?.title ?? t("view_live") });
  }

  /** Return what to run. */
  request() {
    const { registry, store } = this.page;
    let { scenario, options } = store.state;
    if (!scenario && !options.system) {
      scenario = FIRST;
      options = { ...FIRST_OPTIONS, ...options };
    }
    if (scenario && options.system)
      options = withLaws(registry, options, {}, options.system, options.drive ?? "fixed_pivot");
    this.preset.show(scenario);
    return { scenario, options };
  }

  /** @param {Toy} toy */
  start(toy) {
    const { controls, limits, system } = toy;
    this.toy = toy;
    this.motion = new LiveMotion(toy);
    const names = Object.keys(controls);
    if (names.join() !== Object.keys(this.knobs).join()) this.makeKnobs(names);
    for (const name of names) {
      const ends = /** @type {Record<string, number>} */ ({
        drive_amplitude: SLIDER.drive_amplitude * this.motion.longest,
        drive_frequency: SLIDER.drive_frequency * system.naturalFrequency,
        damping: Math.max(SLIDER.damping * limits[name][1], 4 * controls.damping),
      });
      this.knobs[name].allow(limits[name], ends[name] ?? limits[name][1]);
      this.knobs[name].show(controls[name]);
      this.knobs[name].error(null);
    }
    const single = this.motion.balls.length < 2;
    this.root.classList.toggle("single", single);
    this.watch.begin(single);
    this.rescale();
    this.pace.rest();
    this.dirty = true;
    this.allow(true);
    this.root.dataset.ready = "true";
  }

  /**
   * Let the buttons that move a toy be pressed, or not.
   * @param {boolean} hasToy
   */
  allow(hasToy) {
    const { toggle, push, restart, high, low } = this.parts;
    for (const button of [toggle, push, restart, high, low, this.keeper.button])
      button.disabled = !hasToy;
  }

  /** Begin again, with the controls as they are. */
  restart() {
    this.keeper.finish();
    if (this.toy) this.start(this.toy.restarted());
  }

  /** @param {string[]} names */
  makeKnobs(names) {
    this.knobs = Object.fromEntries(names.map((name) => [name,
      new Knob(this.page.registry.options[name] ?? this.page.registry.options[`right_${name}`],
        KEYS[name] ?? [], (value) => this.set(name, value),
        (text, actions) => this.say(text, actions, true))]));
    this.parts.knobs.replaceChildren(...Object.values(this.knobs).map((knob) => knob.root));
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
    this.toy.set({ [name]: value });
    this.dirty = true;
    if (name === "drive_amplitude") this.rescale();
    const options = withControls(registry, store.state.options, this.toy.system.kind,
      this.toy.controls, name);
    const scenario = store.state.scenario ?? (options.system ? null : FIRST);
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
        const clacks = toy.clack > SOFTEST;
        this.watch.add(motion, clacks);
        if (clacks) {
          this.clack.sound(toy.clack / (LOUDEST * toy.system.naturalFrequency));
          if (!this.calm) [this.scene.flash, this.scene.flashAt] = [0, performance.now()];
        }
        toy.clack = 0;
        this.dirty = true;
      });
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      // The memory that it computed in may be spoiled: begin in a new one.
      void this.begin().then(() => {
        this.say(t("liveFault", { text: error.message }));
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
    if (!this.dirty || !this.motion || !this.toy) return;
    this.dirty = false;
    const { toy, motion, pace } = this;
    if (motion.rise(this.watch.largest())) this.scene.box = motion.box();
    this.scene.time = toy.time;
    this.scene.draw();
    this.watch.draw(this.paused);
    if (now - this.readAt < READ_EVERY) return;
    this.readAt = now;
    const text = motion.balls.length > 1 ? "liveReadout" : "liveReadoutOne";
    const ratio = toy.controls.drive_frequency / toy.system.naturalFrequency;
    this.parts.status.textContent = t(text, {
      time: toy.time.toFixed(1), count: toy.contacts, ratio: ratio.toFixed(3),
    }) + (pace.share < SLOW ? t("liveSlow", { share: (pace.share * pace.speed).toFixed(2) }) : "");
    this.showRatio(ratio);
    this.keeper.show();
  }

  /** @param {number} ratio of the driving frequency to the natural one */
  showRatio(ratio) {
    this.knobs.drive_frequency.also.textContent = t("ratioText", { ratio: ratio.toFixed(3) });
    for (const name of /** @type {("high" | "low")[]} */ (["high", "low"]))
      this.parts[name].setAttribute("aria-pressed", String(Math.abs(ratio - RATIOS[name]) < 2e-3));
  }

  pause() {
    this.paused = !this.paused;
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
    if (this.toy) this.knobs.drive_frequency.give(ratio * this.toy.system.naturalFrequency);
  }

  /** Return what each key does. @returns {Record<string, () => void>} */
  actions() {
    return {
      ArrowUp: () => this.knobs.drive_amplitude?.turn(1),
      ArrowDown: () => this.knobs.drive_amplitude?.turn(-1),
      ArrowRight: () => this.knobs.drive_frequency?.turn(1),
      ArrowLeft: () => this.knobs.drive_frequency?.turn(-1),
      d: () => this.knobs.damping?.turn(1), D: () => this.knobs.damping?.turn(-1),
      e: () => this.knobs.restitution?.turn(1), E: () => this.knobs.restitution?.turn(-1),
      p: () => this.push(), r: () => this.restart(), c: () => this.keeper.toggle(),
      1: () => this.ratio(RATIOS.high), 2: () => this.ratio(RATIOS.low), " ": () => this.pause(),
    };
  }

  /**
   * Show why there is no toy.
   * @param {Error} error
   */
  refuse(error) {
    const [message, field] = inPagesWords(this.page.registry, error);
    this.knobs[field ?? ""]?.error(message);
    this.say(sentence(this.page.registry, error), waysOn(this.page, error), true);
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
