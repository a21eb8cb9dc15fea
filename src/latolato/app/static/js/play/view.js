/** Play: the motion, three knobs beside it, and everything else one click away. */

import { codeBlocks } from "../shared/code.js";
import { el, tell } from "../shared/dom.js";
import { Downloads } from "./downloads.js";
import { Form } from "../shared/form.js";
import { followKeys } from "../shared/keys.js";
import { Knobs, spansOf, tellingOptions } from "../shared/knobs.js";
import { naturalFrequency, withLaws } from "../shared/laws.js";
import { LongRunError, Runner } from "../model/client.js";
import { inPagesWords } from "../model/words.js";
import { FIRST } from "../shared/state.js";
import { Motion } from "../shared/motion.js";
import { Player } from "../shared/player.js";
import { presetField } from "../shared/presets.js";
import { t } from "../strings.js";

/** @typedef {import("../shared/state.js").Page} Page */

// Beyond it, a run that is computed is announced.
const PATIENCE = 700; // ms
// Where the address names a recording of Live that this page still has.
const RECORDING = "play.recording";

export class PlayView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    // The worker loads while the rest is made.
    this.runner = new Runner(page.registry);
    this.runner.start();
    const form = el("form", { class: "form", on: {
      submit: (/** @type {Event} */ e) => e.preventDefault() } });
    this.form = new Form(form, page.registry, page.store);
    this.presets = presetField(page);
    this.knobs = new Knobs(page.registry, (name, text) => this.form.give(name, text || null));
    this.knobsFor = "";
    // Its place is kept while there is nothing to take back.
    this.reset = el("button", { type: "button", class: "reset", on: { click: () =>
      page.store.set({ options: {} }) } }, t("reset"));
    this.notes = el("p", { class: "notes", role: "status" });
    this.choice = el("div", { class: "actions" });
    this.code = el("div", {});
    this.downloads = new Downloads(page);
    const drawer = (/** @type {string} */ name, /** @type {(Node | string)[]} */ ...content) =>
      el("details", { class: "card" }, el("summary", {}, t(name)), ...content);
    this.more = drawer("moreParameters", form);
    const place = el("div", { class: "player" });
    this.player = new Player(place);
    this.player.messages.append(this.notes, this.choice);
    this.player.tools.append(this.makeShare());
    this.presets.head.append(this.reset, this.makePin());
    place.prepend(el("div", { class: "desk" }, this.presets.question, this.player.bench,
      el("aside", { class: "side" }, el("div", { class: "card" }, this.presets.field), this.knobs.root,
        el("div", { class: "drawers" }, this.more, this.downloads.root,
          drawer("code", el("p", { class: "hint" }, t("codeHint")), this.code)))));
    this.root = el("div", { class: "view play" }, place);
    /** Whether a run has been shown, and whether the clock goes on when the view comes back. */
    this.hasBegun = this.goesOn = false;
    /** @type {(() => void)[]} what ends listening */
    this.releases = [];
  }

  makePin() {
    const pin = el("button", { type: "button", on: { click: () => {
      pin.textContent = t(this.player.togglePin() ? "unpin" : "pin");
    } } }, t("pin"));
    return pin;
  }

  makeShare() {
    return el("button", { type: "button", class: "plain", on: { click: async () => {
      await navigator.clipboard.writeText(location.href);
      tell(t("copied"));
    } } }, t("share"));
  }

  show() {
    this.releases.push(followKeys(document, this.player.actions));
    this.releases.push(this.page.store.subscribe((state, changed) => {
      if (changed === "extra") return;
      // Whoever changes a parameter wants a run of these parameters.
      if (["options", "preset"].includes(changed) && RECORDING in state.extra)
        this.page.store.keep(RECORDING, null);
      if (changed === "preset") this.player.restart();
      void this.simulate();
    }));
    void this.simulate();
    if (this.goesOn) this.player.clock.play();
  }

  hide() {
    for (const release of this.releases.splice(0)) release();
    this.downloads.stop();
    this.runner.stop();
    this.goesOn = this.player.clock.playing;
    this.player.clock.pause();
  }

  /** Return the recording that the address names, null without one. */
  recording() {
    const { store, recordings } = this.page;
    const name = store.state.extra[RECORDING];
    if (name === undefined) return null;
    const recording = recordings && Object.hasOwn(recordings, name) ? recordings[name] : null;
    if (!recording) {
      tell(t("recordingGone"));
      store.keep(RECORDING, null);
    }
    return recording;
  }

  /**
   * Say something on the stage, and offer what can be done about it.
   * @param {string} text
   * @param {string} [label] of a button
   * @param {() => void} [act]
   */
  note(text, label, act) {
    this.notes.textContent = text;
    this.choice.replaceChildren(...(label
      ? [el("button", { type: "button", on: { click: act } }, label)] : []));
  }

  /** Say that a run is computed, and offer to stop it. */
  wait() {
    this.note(t("computing"), t("stop"), () => {
      this.runner.stop();
      this.runner.end();
      this.note(t("runStopped"));
    });
  }

  /**
   * Simulate what the address asks for, and show it.
   * @param {boolean} [isAgreed] however long that takes
   */
  async simulate(isAgreed = false) {
    const { registry, store } = this.page;
    let { scenario, options } = store.state;
    const chosen = scenario;
    if (!scenario && !options.system) scenario = FIRST;
    if (scenario && options.system) {
      // A scenario's own values do not fit another system.
      options = withLaws(registry, options, {}, options.system, options.drive ?? "fixed_pivot");
    }
    this.presets.show(scenario);
    this.reset.classList.toggle("idle", !scenario || Object.keys(store.state.options).length === 0);
    // The form is made while the worker computes.
    this.choice.replaceChildren();
    const waiting = setTimeout(() => {
      this.wait();
      // The button that agreed is gone.
      if (isAgreed) this.choice.querySelector("button")?.focus();
    }, isAgreed ? 0 : PATIENCE);
    const pending = this.recording() ?? this.runner.compute({ scenario, options }, { isAgreed });
    this.form.build();
    try {
      const block = await pending;
      // A run that was under way when another preset was chosen.
      if (store.state.scenario !== chosen) return;
      const motion = new Motion(block);
      this.form.show(block.about.options);
      this.showKnobs(motion, scenario);
      this.player.show(motion);
      const { warnings, note } = block.about;
      this.note([...warnings, ...(note ? [note] : [])].map((text) => t("warning", { text })).join(" "));
      this.showCode(block.about);
      this.downloads.show({ scenario, options }, block.about.balls.length > 1);
      this.root.dataset.runs = String(Number(this.root.dataset.runs ?? 0) + 1);
      this.begin();
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return;
      if (!(error instanceof Error)) throw error;
      if (error instanceof LongRunError) {
        this.note(error.message, t("computeLong"), () => void this.simulate(true));
        return;
      }
      this.refuse(...inPagesWords(registry, error));
    } finally {
      clearTimeout(waiting);
    }
  }

  /** Let the first run move, unless somebody wants little motion or another page has this one. */
  begin() {
    if (this.hasBegun) return;
    this.hasBegun = true;
    const isCalm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (!isCalm && !this.page.store.state.embed) this.player.clock.play();
  }

  /**
   * Show the knobs that tell most about a run.
   * @param {Motion} motion
   * @param {string | null} scenario
   */
  showKnobs({ about, balls, low, high }, scenario) {
    const { registry, store } = this.page;
    const { options } = about;
    const names = tellingOptions(registry, options);
    const subject = JSON.stringify([scenario, options.system, options.drive, names]);
    if (subject !== this.knobsFor) {
      this.knobsFor = subject;
      this.knobs.make(names);
      const [{ length, mass }] = balls;
      this.knobs.allow(spansOf({ length, mass, naturalFrequency: naturalFrequency(options),
        low: low ?? undefined, high: high ?? undefined, values: options }));
    }
    for (const [name, knob] of Object.entries(this.knobs.all))
      knob.read(this.form.text(name), store.state.options[name] !== undefined);
    this.knobs.error(null);
  }

  /**
   * Say why there is no such run: beside its knob or field, on the stage where neither is seen.
   * @param {string} text
   * @param {string | null} [field]
   */
  refuse(text, field = null) {
    const hasField = field !== null && this.form.fields.has(field);
    this.form.error(hasField ? text : null, field);
    const isSeen = this.knobs.error(text, field) || (hasField && this.more.open);
    this.note(isSeen ? "" : text);
  }

  /** @param {any} about */
  showCode(about) {
    this.code.replaceChildren(...codeBlocks([about.python, about.command].filter(Boolean)));
  }
}
