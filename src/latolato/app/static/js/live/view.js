/** Live: the toy runs in real time while hands change everything. */

import { Clack } from "../shared/clack.js";
import { tell } from "../shared/dom.js";
import { followKeys } from "../shared/keys.js";
import { withLaws } from "../shared/laws.js";
import { presetField } from "../shared/presets.js";
import { Scene } from "../shared/scene.js";
import { waited } from "../shared/waiting.js";
import { t } from "../strings.js";
import { withControls } from "./address.js";
import { followHand } from "./hand.js";
import { Keeper } from "./keeper.js";
import { KEYS, Knob } from "./knob.js";
import { Link, stateOf } from "./link.js";
import { LiveMotion } from "./motion.js";
import { layOut, makeParts } from "./parts.js";
import { Watch } from "./watch.js";

/** @typedef {import("../shared/state.js").Page} Page */
/** @typedef {import("./link.js").Frame} Frame */

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
const FLAG_PAUSED = 1;
// How far the sliders go: lengths, natural frequencies, and a share of what the server takes.
const SLIDER = { drive_amplitude: 0.25, drive_frequency: 5, damping: 0.05 };

export class LiveView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    this.shown = false;
    this.paused = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.calm = this.paused;
    /** @type {any} */
    this.about = null;
    /** @type {LiveMotion | null} */
    this.motion = null;
    /** What the server is asked to go on from after a break. @type {any} */
    this.last = null;
    /** @type {Record<string, number> | null} */
    this.controls = null;
    this.signature = "";
    this.dirty = false;
    this.readAt = 0;
    /** Called when the toy moves, or cannot. @type {() => void} */
    this.arrived = () => {};
    this.preset = presetField(page);
    this.link = new Link({
      hello: () => this.hello(),
      ready: (about) => this.ready(about),
      frame: (frame) => this.see(frame),
      error: (text, field) => this.refuse(text, field),
      recorded: (about) => this.keeper.finish(about),
      connected: (is) => this.connected(is),
    });
    this.keeper = new Keeper(page, (record) => this.link.send({ record }));
    /** @type {Record<string, Knob>} */
    this.knobs = {};
    this.clack = new Clack();
    this.parts = makeParts(RATIOS, {
      sound: (on) => { this.clack.on = on; },
      pause: () => this.pause(),
      push: () => this.push(),
      restart: () => this.link.send({ reset: true }),
      high: () => this.ratio(RATIOS.high),
      low: () => this.ratio(RATIOS.low),
    });
    this.root = layOut(this.parts, this.keeper.button, this.keeper.result, this.preset.field);
    this.scene = new Scene(this.parts.canvas);
    this.watch = new Watch(this.parts.angle.canvas, this.parts.energy.canvas);
    followHand(this.parts.canvas, this.scene, () => this.motion,
      (drag) => this.link.send({ drag }));
    followKeys(this.root, this.actions());
    document.addEventListener("visibilitychange", () => this.holdOrGoOn());
    this.draw = this.draw.bind(this);
    /** @type {() => void} */
    this.unsubscribe = () => {};
  }

  show() {
    this.shown = true;
    this.unsubscribe = this.page.store.subscribe((_, changed) => {
      if (changed !== "extra" && changed !== "view" && this.wish() !== this.signature) this.begin();
    });
    if (this.wish() !== this.signature || !this.link.socket) this.begin();
    else this.holdOrGoOn();
    this.parts.canvas.focus({ preventScroll: true });
    requestAnimationFrame(this.draw);
  }

  hide() {
    this.shown = false;
    this.unsubscribe();
    if (this.keeper.running) this.keeper.toggle();
    this.holdOrGoOn();
  }

  /** Return what the address asks for, as a text to compare. */
  wish() {
    const { scenario, options } = this.page.store.state;
    return JSON.stringify([scenario, options]);
  }

  /** Begin with what the address asks for. */
  begin() {
    this.signature = this.wish();
    this.last = null;
    this.controls = null;
    this.link.open();
    this.arrived();
    /** @type {Promise<void>} */
    const ready = new Promise((resolve) => { this.arrived = resolve; });
    void waited(this.parts.notice, ready);
  }

  /** Return the greeting: what to run and, after a break, where it was. */
  hello() {
    const { registry, store } = this.page;
    let { scenario, options } = store.state;
    if (!scenario && !options.system) {
      scenario = FIRST;
      options = { ...FIRST_OPTIONS, ...options };
    }
    if (scenario && options.system)
      options = withLaws(registry, options, {}, options.system, options.drive ?? "fixed_pivot");
    this.preset.show(scenario);
    return { scenario, options, controls: this.controls, state: this.last };
  }

  /** @param {any} about */
  ready(about) {
    this.arrived();
    this.about = about;
    this.motion = new LiveMotion(about);
    this.controls = about.controls;
    const names = Object.keys(about.controls);
    if (names.join() !== Object.keys(this.knobs).join()) this.makeKnobs(names);
    const longest = this.motion.longest;
    for (const name of names) {
      const limits = about.limits[name];
      const ends = /** @type {Record<string, number>} */ ({
        drive_amplitude: SLIDER.drive_amplitude * longest,
        drive_frequency: SLIDER.drive_frequency * about.natural_frequency,
        damping: Math.max(SLIDER.damping * limits[1], 4 * about.controls.damping),
      });
      this.knobs[name].allow(limits, ends[name] ?? limits[1]);
      this.knobs[name].show(about.controls[name]);
      this.knobs[name].error(null);
    }
    const single = this.motion.balls.length < 2;
    this.root.classList.toggle("single", single);
    this.watch.begin(!this.last, single);
    this.rescale();
    this.parts.notice.textContent = about.by_cosine ? "" : t("liveCosine");
    this.holdOrGoOn();
    this.root.dataset.ready = "true";
  }

  /** @param {string[]} names */
  makeKnobs(names) {
    this.knobs = Object.fromEntries(names.map((name) => [name,
      new Knob(this.page.registry.options[name] ?? this.page.registry.options[`right_${name}`],
        KEYS[name] ?? [], (value) => this.set(name, value))]));
    this.parts.knobs.replaceChildren(...Object.values(this.knobs).map((knob) => knob.root));
  }

  /**
   * Ask for a new value, and keep it in the address for the other views.
   * @param {string} name
   * @param {number} value in SI units
   */
  set(name, value) {
    if (!this.controls) return;
    this.controls[name] = value;
    this.link.send({ set: { [name]: value } });
    if (name === "drive_amplitude") this.rescale();
    const { registry, store } = this.page;
    const options = withControls(registry, store.state.options, this.about.options.system,
      this.controls, name);
    const scenario = store.state.scenario ?? (options.system ? null : FIRST);
    this.signature = JSON.stringify([scenario, options]);
    store.set({ scenario, options });
  }

  rescale() {
    if (!this.motion || !this.controls) return;
    this.motion.reach = this.controls.drive_amplitude;
    this.scene.show(/** @type {any} */ (this.motion));
  }

  /** @param {Frame} frame */
  see(frame) {
    const { motion, about } = this;
    if (!motion) return;
    motion.frame = frame;
    this.last = stateOf(frame, about.angles);
    const clacks = frame.clack > SOFTEST;
    this.watch.add(frame, motion, clacks);
    if (clacks) {
      this.clack.sound(frame.clack / (LOUDEST * about.natural_frequency));
      if (!this.calm) [this.scene.flash, this.scene.flashAt] = [0, performance.now()];
    }
    this.dirty = true;
  }

  /** Draw the newest frame, once for each picture of the screen. */
  draw() {
    if (!this.shown) return;
    requestAnimationFrame(this.draw);
    if (!this.dirty || !this.motion) return;
    this.dirty = false;
    if (this.motion.rise(this.watch.largest())) this.scene.box = this.motion.box();
    this.scene.time = this.motion.frame.time;
    this.scene.draw();
    this.watch.draw();
    const now = performance.now();
    if (now - this.readAt < READ_EVERY) return;
    this.readAt = now;
    const { frame } = this.motion;
    const text = this.motion.balls.length > 1 ? "liveReadout" : "liveReadoutOne";
    this.parts.status.textContent = t(text, {
      time: frame.time.toFixed(1), count: frame.contacts,
      ratio: (frame.drive_frequency / this.about.natural_frequency).toFixed(3) });
    this.showRatio();
    this.keeper.show(frame.recorded);
    this.showPause(Boolean(frame.flags & FLAG_PAUSED));
  }

  showRatio() {
    if (!this.controls) return;
    const ratio = this.controls.drive_frequency / this.about.natural_frequency;
    this.knobs.drive_frequency.also.textContent = t("ratioText", { ratio: ratio.toFixed(3) });
    for (const name of /** @type {("high" | "low")[]} */ (["high", "low"]))
      this.parts[name].setAttribute("aria-pressed", String(Math.abs(ratio - RATIOS[name]) < 2e-3));
  }

  pause() {
    this.paused = !this.paused;
    this.holdOrGoOn();
  }

  /** Let the toy move if it is seen and not paused. */
  holdOrGoOn() {
    this.link.send({ pause: this.paused || !this.shown || document.hidden });
    this.showPause(this.paused);
  }

  /** @param {boolean} is */
  showPause(is) {
    const label = t(is ? "play" : "pause");
    if (this.parts.toggle.textContent !== label) this.parts.toggle.textContent = label;
  }

  push() {
    if (this.about) this.link.send({ push: PUSH * this.about.natural_frequency });
  }

  /** @param {number} ratio */
  ratio(ratio) {
    if (!this.about) return;
    this.knobs.drive_frequency.give(ratio * this.about.natural_frequency);
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
      p: () => this.push(), r: () => this.link.send({ reset: true }), c: () => this.keeper.toggle(),
      1: () => this.ratio(RATIOS.high), 2: () => this.ratio(RATIOS.low), " ": () => this.pause(),
    };
  }

  /**
   * @param {string} text
   * @param {string | null} field
   */
  refuse(text, field) {
    this.arrived();
    if (this.last && !this.link.isReady) {
      // The server no longer takes what it was asked to go on from: begin anew.
      this.last = this.controls = null;
      this.link.open();
    }
    if (field && this.knobs[field]) this.knobs[field].error(text);
    else this.parts.notice.textContent = text;
  }

  /** @param {boolean} is */
  connected(is) {
    this.root.dataset.connected = String(is);
    if (!is) {
      this.parts.notice.textContent = t("offline");
      if (this.keeper.running) this.keeper.lose();
    } else if (this.last) {
      this.parts.notice.textContent = "";
      tell(t("liveBack"));
    }
  }
}
