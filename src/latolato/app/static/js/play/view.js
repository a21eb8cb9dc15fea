/** Play: parameters on one side, the motion that they make on the other. */

import { codeBlocks } from "../shared/code.js";
import { el } from "../shared/dom.js";
import { Downloads } from "./downloads.js";
import { Form } from "../shared/form.js";
import { followKeys } from "../shared/keys.js";
import { withLaws } from "../shared/laws.js";
import { LongRunError, Runner } from "../model/client.js";
import { inPagesWords } from "../model/words.js";
import { FIRST } from "../shared/state.js";
import { Motion } from "../shared/motion.js";
import { Player } from "../shared/player.js";
import { sentence, waysOn } from "../shared/reading.js";
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
    this.presets = presetField(page);
    const stage = el("div", { class: "player" });
    this.code = el("div", {});
    this.downloads = new Downloads(page);
    this.root = el("div", { class: "view split" },
      el("aside", { class: "side" }, this.presets.field, this.makeActions(),
        this.downloads.root, form),
      el("div", { class: "main" }, el("div", { class: "stage-messages" }), stage, el("details", { class: "card" },
        el("summary", {}, t("code")), el("p", { class: "hint" }, t("codeHint")), this.code)));
    this.form = new Form(form, page.registry, page.store);
    this.player = new Player(stage);
    /** @type {(() => void)[]} what ends listening */
    this.releases = [];
  }

  makeActions() {
    this.pin = el("button", { type: "button", on: { click: () => {
      const pinned = this.player.togglePin();
      if (this.pin) this.pin.textContent = t(pinned ? "unpin" : "pin");
    } } }, t("pin"));
    return el("div", { class: "actions" }, this.pin, el("div", { class: "stage-tools" }));
  }

  /** Return a picture of the stage. */
  async picture() {
    const { captionOf, stagePicture } = await import("../shared/picture.js");
    const { scenario } = this.page.store.state;
    return stagePicture(this.player.scene, { caption: captionOf(this.player.motion?.about.options ?? {}),
      title: this.page.registry.scenarios[scenario ?? ""]?.title ?? t("presetNone") });
  }

  show() {
    this.releases.push(followKeys(document, this.player.actions));
    this.releases.push(this.page.store.subscribe((state, changed) => {
      if (changed === "extra") return;
      // Whoever changes a parameter wants a run of these parameters.
      if (["options", "preset"].includes(changed) && RECORDING in state.extra)
        this.page.store.drop([RECORDING]);
      void this.simulate();
    }));
    void this.simulate();
  }

  hide() {
    for (const release of this.releases.splice(0)) release();
    this.downloads.stop();
    this.runner.stop();
    this.player.clock.pause();
  }

  /** Return the recording that the address names, null without one. */
  recording() {
    const { store, recordings } = this.page;
    const name = store.state.extra[RECORDING];
    if (name === undefined) return null;
    const recording = recordings && Object.hasOwn(recordings, name) ? recordings[name] : null;
    if (!recording) {
      this.page.messages.say("recording", t("recordingGone"));
      store.drop([RECORDING]);
    }
    return recording;
  }

  /**
   * Say something about the run on show, and offer what can be done about it.
   * @param {string} text
   * @param {import("../shared/messages.js").Action[]} [actions]
   * @param {boolean} [isBad] whether the run was refused
   */
  note(text, actions, isBad) {
    this.page.messages.say("run", text, { stays: true, actions, isBad });
  }

  /** Say that a run is computed, and offer to stop it. */
  wait() {
    this.note(t("computing"), [{ label: t("stop"), act: () => {
      this.runner.stop();
      this.runner.end();
      this.note(t("runStopped"));
    } }]);
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
    // The form is made while the worker computes.
    const waiting = setTimeout(() => {
      this.wait();
      // The button that agreed is gone.
      if (isAgreed) this.page.messages.root.querySelector("button")?.focus();
    }, isAgreed ? 0 : PATIENCE);
    const pending = this.recording() ?? this.runner.compute({ scenario, options }, { isAgreed });
    this.form.build();
    try {
      const block = await pending;
      // A run that was under way when another preset was chosen.
      if (store.state.scenario !== chosen) return;
      const motion = new Motion(block);
      this.form.show(block.about.options);
      this.player.show(motion);
      const { warnings, note } = block.about;
      this.note([...warnings, ...(note ? [note] : [])].map((text) => t("warning", { text })).join(" "));
      this.showCode(block.about);
      this.downloads.show({ scenario, options }, block.about.balls.length > 1);
      this.root.dataset.runs = String(Number(this.root.dataset.runs ?? 0) + 1);
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return;
      if (!(error instanceof Error)) throw error;
      if (error instanceof LongRunError) {
        this.note(error.message, [{ label: t("computeLong"), act: () => void this.simulate(true) }]);
        return;
      }
      this.note(sentence(registry, error), waysOn(this.page, error), true);
      this.form.error(...inPagesWords(registry, error));
    } finally {
      clearTimeout(waiting);
    }
  }

  /** @param {any} about */
  showCode(about) {
    this.code.replaceChildren(...codeBlocks([about.python, about.command].filter(Boolean)));
  }
}
