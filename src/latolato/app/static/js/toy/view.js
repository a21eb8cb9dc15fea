/** Toy: the motion, three knobs beside it, a hand that takes it, and everything else one click away. */

import { firstWorker } from "../first_run.js";
import { beforePrint, el, freshId, isCalm } from "../page/dom.js";
import { followKeys } from "../page/keys.js";
import { Knobs } from "../page/knobs.js";
import { hungOn, naturalFrequency, withLaws, withOptions } from "../page/option_texts.js";
import { actingLink, openLink } from "../page/links.js";
import { sayOffline } from "../page/messages.js";
import { Motion } from "../player/motion.js";
import { Player } from "../player/player.js";
import { presetField } from "../page/presets.js";
import { inPagesWords, warningsText } from "../page/refusals.js";
import { Runner } from "../player/runner.js";
import { withStart } from "../player/start.js";
import { FIRST, HELD, PLAYED } from "../page/state.js";
import { DEGREE } from "../page/unit_text.js";
import { t, tr } from "../strings.js";

/** @typedef {import("../page/state.js").Page} Page */

// Beyond it, a run that is computed is announced.
const PATIENCE = 700; // ms
// What may change without making another toy of the first one.
const FREE = ["drive_frequency", "frequency_ratio"];
// Where the question with which the page opens is answered at length.
const STORIES = { why_twice: "Why twice?", first_clack: "From rest to clack" };

export class ToyView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    this.runner = new Runner(page.registry, firstWorker);
    this.fields = el("form", { class: "form", on: {
      submit: (/** @type {Event} */ e) => e.preventDefault() } });
    /** See `makeForm`. @type {import("../page/form.js").Form | null} */
    this.form = null;
    /** What the run on show had, in SI units. @type {Record<string, any>} */
    this.resolved = {};
    /** Why there is no such run as asked for. @type {Error | null} */
    this.refused = null;
    this.presets = presetField(page);
    this.knobs = new Knobs(page.registry, (name, text, value) => {
      if (this.hand?.isOn) this.hand.turn(name, Number(value));
      else this.give({ [name]: text || null });
    });
    /** Holds the toy when it is first asked to. @type {import("./hand.js").Hand | null} */
    this.hand = null;
    this.hold = el("button", { type: "button", class: "hold", "aria-pressed": "false", title: t("holdHint"),
      on: { click: () => page.store.keep(HELD, HELD in page.store.state.extra ? null : "1") } }, t("hold"));
    // Its place is kept while there is nothing to take back.
    this.reset = el("button", { type: "button", class: "reset", on: { click: () =>
      page.store.set({ options: {} }, "preset") } }, t("reset"));
    this.code = el("div", {});
    const drawer = (/** @type {string} */ name, /** @type {string} */ looks, /** @type {() => Promise<void>} */ fill,
      /** @type {(Node | string)[]} */ ...content) => el("details", { class: looks,
      on: { toggle: () => void fill() } }, el("summary", {}, t(name)), ...content);
    this.more = drawer("moreParameters", "card", () => this.makeForm(), this.fields);
    this.drawer = drawer("download", "card downloads of-run", () => this.openDownloads());
    /** Made when its drawer is first opened. @type {import("./downloads.js").Downloads | null} */
    this.downloads = null;
    /** Whose files it offers: the run on show. @type {Parameters<import("./downloads.js").Downloads["show"]> | null} */
    this.offered = null;
    this.lines = drawer("code", "card of-run", () => this.showCode(), el("p", { class: "hint" }, t("codeHint")), this.code);
    const place = el("div", { class: "player" });
    this.player = new Player(place);
    this.player.accessibility.nameOf = (name) => this.knobs.inWords().options[name]?.label;
    this.player.start.enable((degrees) => this.startAt(degrees));
    this.player.button?.after(this.hold);
    const pin = el("button", { type: "button", class: "of-run", on: { click: () => {
      pin.textContent = t(this.player.togglePin() ? "unpin" : "pin");
    } } }, t("pin"));
    this.presets.head.append(this.reset, pin);
    const hangId = freshId();
    this.hang = el("select", { id: hangId, on: { change: () => this.give(hungOn(page.store.state.options, this.resolved, this.hang.value)) } },
      ...["rod", "string"].map((each) => el("option", { value: each }, tr(each))));
    this.hanging = el("div", { class: "field hanging" }, el("label", { for: hangId }, t("hangsOn")), this.hang);
    this.highest = el("span", {});
    this.answer = el("span", { hidden: true }, ...Object.entries(STORIES).flatMap(
      ([name, title]) => [" ", openLink(page, { view: "toy", scenario: null, options: {},
        extra: { "story.name": name } }, tr(title))]));
    const stories = actingLink("?view=toy&story.list=1", () => page.store.keep("story.list", "1"),
      { class: "open" }, t("stories"));
    this.presets.told.append(this.highest, this.answer);
    this.presets.field.append(el("p", { class: "stories-link" }, stories));
    this.player.clock.subscribe((time) => this.tellHighest(time));
    place.prepend(el("div", { class: "desk" }, this.presets.headline, this.player.bench,
      el("aside", { class: "side" }, el("div", { class: "card" }, this.presets.field, this.hanging), this.knobs.root,
        el("div", { class: "drawers" }, this.more, this.drawer, this.lines))));
    this.root = el("div", { class: "view toy" }, place);
    /** Whether a slider moves, and whether the last run was therefore thinned. */
    this.isSliding = this.isThinned = false;
    this.root.addEventListener("input", ({ target }) => {
      this.isSliding = target instanceof HTMLInputElement && target.type === "range";
    }, { capture: true });
    this.root.addEventListener("change", () => this.endSlide(), { capture: true });
    /** Whether a run has been shown, and whether the clock goes on when the view comes back. */
    this.hasBegun = this.goesOn = false;
    /** @type {(() => void)[]} what ends listening */
    this.releases = [];
    this.endKeys = () => {};
  }

  /** Return a picture of the stage. */
  async picture() {
    const { captionOf, stagePicture } = await import("../player/picture.js");
    const { scenario } = this.page.store.state;
    return stagePicture(this.player.scene, { caption: captionOf(this.player.motion?.about.options ?? {}),
      title: this.page.registry.scenarios[scenario ?? ""]?.title ?? t("presetNone") });
  }

  show() {
    this.listen();
    this.releases.push(beforePrint(() => this.player.clock.pause()));
    this.releases.push(this.page.store.subscribe((state, changed) => this.follow(state, changed)));
    const isHeld = HELD in this.page.store.state.extra;
    if (isHeld && this.hand?.toy) this.hand.follow(false);
    else if (isHeld) void this.take();
    else if (this.hand?.isOn) this.letGo();
    else void this.simulate();
    if (this.goesOn) this.player.clock.play();
  }

  /** Follow the keys that do something now. */
  listen() {
    this.endKeys();
    const keys = Object.entries(this.player.keys());
    // Elsewhere on the page arrows scroll.
    this.endKeys = followKeys(document, Object.fromEntries(keys.filter(([key]) => !key.startsWith("Arrow"))));
  }

  hide() {
    this.endKeys();
    for (const release of this.releases.splice(0)) release();
    this.downloads?.stop();
    this.runner.stop();
    this.hand?.shake.end();
    this.goesOn = this.player.clock.playing;
    this.player.clock.pause();
  }

  /**
   * Show what the address asks for now.
   * @param {import("../page/state.js").State} state
   * @param {string} changed
   */
  follow(state, changed) {
    const isHeld = this.hand?.isOn ?? false;
    const isAsked = HELD in state.extra;
    if (isAsked !== isHeld) {
      if (isAsked) void this.take();
      else this.letGo();
      return;
    }
    if (changed === "extra") return;
    if (changed === "preset") this.form?.forget();
    if (isHeld) {
      this.hand?.follow(changed === "address");
      return;
    }
    if (changed === "preset") this.player.restart();
    void this.simulate();
  }

  /** Let a hand take the toy. */
  async take() {
    const { clock } = this.player;
    const isPressed = document.activeElement === this.hold;
    this.runner.stop();
    this.page.store.drop([PLAYED]);
    this.note("");
    this.hold.setAttribute("aria-pressed", "true");
    this.hand ??= await this.makeHand();
    if (!(HELD in this.page.store.state.extra)) return;
    const wasShown = this.hasBegun;
    this.hasBegun = true;
    await this.hand.take(isPressed);
    if (!this.hand.isOn) return;
    this.listen();
    if (wasShown || !isCalm()) clock.play();
  }

  /** Let the toy go: the run of the address, or what was kept, is on show again. */
  letGo() {
    this.hold.setAttribute("aria-pressed", "false");
    this.hand?.release();
    this.player.letGo();
    this.listen();
    this.player.start.enable((degrees) => this.startAt(degrees));
    this.knobs.keys = {};
    this.knobs.subject = "";
    void this.simulate();
  }

  async makeHand() {
    const { Hand } = await import("./hand.js");
    const hand = new Hand(this.page, this.player, this.knobs, {
      request: () => this.request(),
      begun: (options) => this.showHeld(options),
      refuse: (error) => this.refuse(error),
    });
    this.hold.after(hand.tools);
    this.player.stage.append(hand.readout);
    this.knobs.root.after(hand.trick, hand.hint);
    this.player.scene.canvas.setAttribute("aria-describedby",
      `${this.player.scene.canvas.getAttribute("aria-describedby")} ${hand.hint.id}`);
    this.player.heldActions = hand.actions();
    followKeys(this.player.stage, Object.fromEntries(Object.entries(hand.actions())
      .filter(([key]) => key.startsWith("Arrow")).map(([key, { text, act }]) =>
        [key, { text, act: (event) => { if (hand.isOn) act(event); } }])));
    return hand;
  }

  /**
   * Show what a hand holds now.
   * @param {Record<string, any>} options in SI units
   */
  showHeld(options) {
    this.presets.show(this.request().scenario);
    this.answer.hidden = true;
    this.reset.classList.toggle("idle", Object.keys(this.page.store.state.options).length === 0);
    this.showOptions(options);
    this.root.dataset.ready = "true";
  }

  /**
   * Say something about the run on show, and offer what can be done about it.
   * @param {string} text
   * @param {import("../page/messages.js").MessageAction[]} [actions]
   * @param {boolean} [isBad] whether the run was refused
   */
  note(text, actions, isBad) {
    this.page.messages.show("run", text, { stays: true, actions, isBad });
  }

  /** Say that a run is computed, and offer to stop it. */
  wait() {
    this.note(t("computing"), [{ label: t("stop"), act: () => {
      this.runner.stop();
      this.runner.end();
      void this.offer(t("runStopped"));
    } }]);
  }

  /** Return the scenario and the options to run. */
  request() {
    const { registry, store } = this.page;
    let { scenario, options } = store.state;
    if (!scenario && !options.system) scenario = FIRST;
    if (scenario && options.system) {
      // A scenario's own values do not fit another system.
      options = withLaws(registry, options, {}, options.system, options.drive ?? "fixed_pivot");
    }
    return { scenario, options };
  }

  /** Show the whole run when a slider is let go. */
  endSlide() {
    this.isSliding = false;
    if (this.isThinned && !this.hand?.isOn) void this.simulate();
  }

  /** The stretch of time that may be on show before a slider is let go: twice what is on show now. @returns {[number, number]} */
  get stretch() {
    const [from, to] = this.player.curves.span;
    return [from, to + (to - from)];
  }

  /** Simulate what the address asks for, and show it. */
  async simulate() {
    const { store } = this.page;
    const { scenario: chosen } = store.state;
    const { scenario, options } = this.request();
    this.presets.show(scenario);
    this.answer.hidden = scenario !== FIRST || "story.name" in store.state.extra;
    const waiting = setTimeout(() => this.wait(), PATIENCE);
    const kept = this.hand?.played.get(store.state.extra[PLAYED]) ?? null;
    this.reset.classList.toggle("idle", !kept && Object.keys(store.state.options).length === 0);
    if (kept) this.hand?.tellKept(kept);
    else if (store.drop([PLAYED])) this.page.messages.showOfStep("kept", t("notKept"), store);
    const { [PLAYED]: name } = store.state.extra;
    this.isThinned = this.isSliding;
    const pending = kept ? Promise.resolve(kept)
      : this.runner.compute({ scenario, options }, { stretch: this.isThinned ? this.stretch : null });
    try {
      const block = await pending;
      // A run that was under way when another preset was chosen.
      if (store.state.scenario !== chosen || this.hand?.isOn || store.state.extra[PLAYED] !== name) return;
      const motion = new Motion(block);
      this.showOptions(block.about.options);
      this.showKnobs(motion, scenario);
      this.player.show(motion);
      this.note(warningsText(block.about.warnings));
      void this.showCode();
      this.offered = [{ scenario, options }, block, kept !== null];
      this.downloads?.show(...this.offered);
      this.root.dataset.runs = String(Number(this.root.dataset.runs ?? 0) + 1);
      this.begin();
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return;
      if (!(error instanceof Error)) throw error;
      this.refuse(error);
    } finally {
      clearTimeout(waiting);
    }
  }

  /** Play the first run, unless the user prefers reduced motion. */
  begin() {
    if (this.hasBegun) return;
    this.hasBegun = true;
    if (!isCalm()) this.player.clock.play();
  }

  /**
   * Show the knobs that tell most about a run.
   * @param {Motion} motion
   * @param {string | null} scenario
   */
  showKnobs(motion, scenario) {
    const { options: own } = this.page.store.state;
    const { options } = motion.about;
    this.knobs.showRun(motion, own, scenario ?? "");
    if (scenario === FIRST && Object.keys(own).every((name) => FREE.includes(name)))
      this.knobs.explain(naturalFrequency(options), t("toyAnswer"));
  }

  /**
   * Set some options, null takes one back.
   * @param {Record<string, string | null>} changed
   */
  give(changed) {
    const { registry, store } = this.page;
    store.set({ options: withOptions(registry, store.state.options, changed) });
  }

  /**
   * Show what a run has.
   * @param {Record<string, any>} options in SI units
   */
  showOptions(options) {
    this.resolved = options;
    this.refused = null;
    this.form?.show(options);
    this.showHanging(options);
  }

  /** Make the form of all parameters, which nobody needs until its drawer is opened or a run is refused. */
  async makeForm() {
    const module = await import("../page/form.js").catch(sayOffline);
    if (!module || this.form) return;
    this.form = new module.Form(this.fields, this.page.registry, this.page.store);
    this.form.show(this.resolved);
  }

  /**
   * Show on what the balls hang, where there is a choice.
   * @param {Record<string, any>} options
   */
  showHanging({ system, suspension = "rod" }) {
    this.hanging.hidden = !this.page.registry.systems[system].options.includes("suspension");
    this.hang.value = suspension;
  }

  /**
   * Say how high the balls have been since the start.
   * @param {number} time
   */
  tellHighest(time) {
    const { motion, clock } = this.player;
    if (motion && clock.isRead) this.highest.textContent = t("highest",
      { angle: Math.round(motion.highest(time) / DEGREE) });
  }

  /**
   * Say why there is no such run: on the stage, and beside its knob and field.
   * @param {Error} error
   */
  async refuse(error) {
    this.refused = error;
    const [module] = await Promise.all([import("../page/link_parts.js").catch(sayOffline), this.makeForm()]);
    if (!module || this.refused !== error) return;
    const ofForm = this.form?.registryInWords ?? this.page.registry;
    const ofKnobs = this.knobs.inWords(ofForm);
    this.form?.error(...inPagesWords(ofForm, error));
    this.knobs.error(...inPagesWords(ofKnobs, error));
    await this.offer(module.sentence(ofKnobs, error), error);
  }

  /**
   * Say that there is no run, with the ways back. Knobs that no run has filled take no room.
   * @param {string} text
   * @param {Error | null} [error] why it was refused
   */
  async offer(text, error = null) {
    this.knobs.root.hidden = !this.player.motion;
    const module = await import("../page/link_parts.js").catch(sayOffline);
    this.note(text, module?.waysBack(this.page, error) ?? [], error !== null);
  }

  /**
   * Ask for the run that begins with the balls at rest at these angles.
   * @param {number[]} degrees
   */
  startAt(degrees) {
    const { motion } = this.player;
    const { store } = this.page;
    if (motion) store.set({ options: withStart(store.state.options, motion.about.options, degrees) });
  }

  /** Make the menu of files when its drawer is first opened. */
  async openDownloads() {
    if (this.downloads || !this.drawer.open) return;
    const module = await import("./downloads.js").catch(sayOffline);
    if (!module || this.downloads) return;
    this.downloads = new module.Downloads(this.page, this.drawer);
    if (this.offered) this.downloads.show(...this.offered);
  }

  /** Show the lines that make the run on show, while their drawer is open. */
  async showCode() {
    const { python, command } = this.player.motion?.about ?? {};
    this.lines.hidden = !python;
    if (!this.lines.open) return;
    const module = await import("../page/code.js").catch(sayOffline);
    if (module) this.code.replaceChildren(...module.codeBlocks([python, command].filter(Boolean)));
  }
}
