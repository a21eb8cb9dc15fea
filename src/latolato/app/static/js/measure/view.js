/** Measure: a video is tracked or a table imported, fitted, and compared with what is computed. */

import { Clock } from "../player/clock.js";
import { Curves } from "../player/curves.js";
import { el, refresh } from "../page/dom.js";
import { findingPlace, showFinding } from "../page/finding.js";
import { textsOf } from "../page/option_texts.js";
import { openState } from "../page/links.js";
import { inPagesWords, learnLabels, sentenceInLanguage, warningsText } from "../page/refusals.js";
import { t, tr } from "../strings.js";
import { answerNumbers, clipList, codeCard, dropCard, exportsCard, guideCard } from "./cards.js";
import { Handles } from "./handles.js";
import { fitCard, refusedCard, trialTable, waitingCard } from "./results.js";
import { Screen } from "./screen.js";
import { isSeen, pivotAndBalls, Session } from "./session.js";
import { Setup } from "./setup.js";
import { choicesOf, chosen, lackOf, SheetCard } from "./sheet.js";
import { handlesOf, Tools, toolsOf } from "./tools.js";
import { panelsOf } from "./track.js";

/** @typedef {import("../page/state.js").Page} Page */
/** @typedef {import("./session.js").Clip} Clip */

/** What of an example's truth somebody would have measured before, by the fields. */
const KNOWN = { length: "centre_length", radius: "radius", mass: "mass" };
/** What sets the parameters that have no field. */
const CONTROLS = { click_frame: "pointHere", balls: "ballCount",
  angle_from: "angleFrom", y_axis: "yDown", pivot: "pivot", section: "sheetPart", decimal: "decimal" };
/** What sets the part of a video, which of a table has fields. */
const OF_VIDEO = { start: "startHere", end: "endHere" };
/** A link with this part clips an example and measures it. */
const LINKED = "measure.example";

export class MeasureView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    this.screen = new Screen();
    this.handles = new Handles(this.screen, (name) => this.corrected(name),
      (name) => this.confirmed(name));
    this.tools = new Tools({ frame: () => this.screen.frame,
      go: (frame) => this.screen.goTo(frame),
      changed: () => this.update(), track: () => this.tracked() });
    this.screen.box.after(this.tools.root);
    this.screen.clock.subscribe(() => this.moved());
    const curves = el("div", { class: "curves" });
    this.curves = new Curves(curves, this.screen.clock, []);
    // A table has no picture whose frames could be the instants.
    this.graph = new Curves(el("div", { class: "curves" }), new Clock(), []);
    /** @type {SheetCard | null} */
    this.sheet = null;
    /** @type {Setup | null} */
    this.setup = null;
    /** @type {Record<string, import("./desk.js").FitKind>} */
    this.kinds = {};
    this.signature = this.content = this.placed = "";
    this.drop = el("div", { class: "clip-drop" });
    this.list = el("div", { class: "clip-list" });
    this.form = el("div", { class: "clip-form" });
    this.exports = el("div", { class: "clip-exports" });
    this.begin = el("div", { class: "welcome" },
      el("section", { class: "card steps" }, el("h2", {}, t("steps")),
        el("ol", {}, ...["step1", "step2", "step3"].map((s) => el("li", {}, t(s))))));
    this.welcome = el("div", { class: "welcome" }, this.begin, guideCard());
    this.finding = findingPlace();
    /** What the place of the answer says: screen readers read each change. */
    this.shown = "";
    this.numbers = el("div", {});
    this.notes = el("p", { class: "notes", role: "status" });
    this.said = el("section", { class: "card answer" }, this.numbers, this.finding, this.notes);
    this.cards = el("div", { class: "cards" });
    this.player = el("div", { class: "player" }, this.screen.root, curves, this.graph.root,
      this.cards);
    this.preview = el("div", { class: "clip-preview" });
    this.trials = el("section", { class: "card clip-trials" });
    this.side = el("aside", { class: "side" }, this.list, this.form);
    this.root = el("div", { class: "view split measure", on: {
      dragover: (/** @type {DragEvent} */ e) => this.dragged(e, true),
      dragleave: (/** @type {DragEvent} */ e) => this.dragged(e, false),
      drop: (/** @type {DragEvent} */ e) => this.dropped(e),
    } },
    this.side, el("div", { class: "main" }, this.welcome, this.said, this.preview, this.player,
      this.trials, this.exports));
    this.session = new Session(() => this.update(), (error) =>
      inPagesWords(this.setup?.form.registryInWords ?? this.page.registry, error));
    this.update();
  }

  show() {
    this.update();
  }

  hide() {
    this.screen.clock.pause();
  }

  /**
   * @param {DragEvent} event
   * @param {boolean} isOver
   */
  dragged(event, isOver) {
    event.preventDefault();
    this.root.classList.toggle("dragged", isOver);
  }

  /** @param {DragEvent} event */
  dropped(event) {
    this.dragged(event, false);
    for (const file of event.dataTransfer?.files ?? []) void this.session.add(file);
  }

  /** Draw everything that depends on the session. */
  update() {
    if (!this.session) return;
    const { desk, clip } = this.session;
    if (desk.hello && !this.setup) this.build(desk.hello);
    const state = clip?.stage ?? clip?.mode ?? "empty";
    this.root.dataset.state = state;
    this.root.classList.toggle("empty", !clip);
    const place = clip ? this.side : this.begin;
    if (this.drop.parentElement !== place) place.append(this.drop);
    const { clips } = this.session;
    refresh(this.list, [clips.map((f) => [f.id, f.stage !== null]), clip?.id], () =>
      [clipList(this.session, (each) => this.open(each))]);
    this.form.hidden = !clip;
    if (clip) this.setUp(clip);
    if (clip) this.tools.update(clip);
    const isKept = this.session.isKept(clip);
    refresh(this.exports,
      [clip?.id, clip?.tracked, clip?.stage !== null, [...clip?.files ?? []], isKept],
      () => (clip?.track && isKept ? [exportsCard(this.session, clip),
        ...(clip.code.length > 0 ? [codeCard(clip.code)] : [])] : []));
    this.welcome.hidden = clip !== null;
    const isResult = clip?.mode === "result";
    this.player.hidden = clip?.sheet ? !isResult : !clip?.about || !clip.url;
    this.player.classList.toggle("alone", !isResult || clip.sheet !== null);
    this.screen.root.hidden = Boolean(clip?.sheet);
    this.graph.root.hidden = !clip?.sheet;
    this.preview.hidden = !clip?.sheet || isResult;
    if (clip) this.sheet?.update(clip);
    const isGone = desk.epoch > 0 && !desk.hello;
    const warnings = clip?.mode === "result" ? clip.warnings : [];
    this.notes.textContent = [...(isGone ? [t("offline")] : []), warningsText(warnings)].join(" ").trim();
    const isAnswer = clip?.mode === "result";
    const text = isAnswer ? clip.finding.map((each) => sentenceInLanguage(each)).join(" ")
      : t(clip?.sheet ? "sheetFinding" : "findingHere");
    refresh(this.numbers, [clip?.id, clip?.tracked, isAnswer],
      () => (isAnswer && clip.answer.length > 0 ? [answerNumbers(clip.answer)] : []));
    this.finding.hidden = !clip || !isSeen(clip);
    if (this.shown !== text) showFinding(this.finding, text, isAnswer);
    this.shown = text;
    this.said.hidden = this.finding.hidden && this.notes.textContent === "";
    if (clip?.about && clip.url) this.showClip(clip);
    if (clip?.sheet) this.showTable(clip);
    this.updateTrials();
  }

  /** @param {Clip} clip whose set-up is shown */
  setUp(clip) {
    if (this.setup) learnLabels(clip.sheet ? this.setup.fields : labelled(OF_VIDEO));
    this.setup?.update(clip, clip.sheet ? lackOf(clip.sheet, this.sheet?.roles ?? {}) : "");
  }

  /** @param {Clip | undefined} clip */
  open(clip) {
    this.session.clip = clip ?? this.session.clip;
    this.update();
  }

  /** @param {import("./desk.js").Hello} hello */
  build(hello) {
    for (const field of Object.values(hello.fields)) {
      field.label = tr(field.label);
      field.description = tr(field.description);
    }
    learnLabels(hello.fields);
    learnLabels(labelled({ ...CONTROLS, ...OF_VIDEO }));
    const setup = new Setup(this.page, hello.fields, {
      changed: () => this.resized(),
      count: (balls) => this.counted(balls),
      track: () => this.tracked(),
      mode: (mode) => this.mode(mode),
      reset: () => this.asProposed(),
      cancel: () => this.session.clip?.cancel(),
      tool: (change) => this.changed(change),
      sheet: (change) => this.sheetChanged(change),
      sign: (decimal) => this.signed(decimal),
    });
    // What a column may be, in the words of the menus above the table.
    const { roles } = hello.tables;
    learnLabels(Object.fromEntries(Object.keys(roles).map((role) => [role, { label: t(`role_${role}`) }])));
    this.sheet = new SheetCard(roles, (change) => this.sheetChanged(change));
    this.preview.replaceChildren(this.sheet.root);
    this.setup = setup;
    this.form.replaceChildren(setup.root);
    this.kinds = Object.fromEntries(hello.fits.map((kind) => [kind.kind, kind]));
    this.drop.replaceChildren(dropCard(hello, (file) => void this.session.add(file),
      (kind) => void this.example(kind)));
    const linked = this.page.store.state.extra[LINKED];
    if (hello.examples.includes(linked)) void this.example(linked).then(() => this.tracked());
  }

  /** @param {string} kind */
  async example(kind) {
    const clip = await this.session.example(kind);
    if (!clip || this.session.clip !== clip) return;
    const values = Object.fromEntries(Object.entries(KNOWN).map(([name, known]) => [name, clip.truth[known]]));
    this.setup?.fill(textsOf(this.page.registry, values));
    this.resized();
  }

  /** @param {Clip} clip */
  showClip(clip) {
    const track = clip.mode === "result" ? clip.track : null;
    const about = /** @type {NonNullable<Clip["about"]>} */ (clip.about);
    const signature = signatureOf(clip);
    if (signature === this.signature) {
      this.place();
      return;
    }
    this.signature = signature;
    const { frame } = this.screen;
    this.screen.show({ ...about, url: clip.url, times: clip.times }, track);
    const content = [clip.id, clip.mode, clip.tracked].join();
    if (content !== this.content) this.screen.goTo(track ? frame : clip.clickFrame);
    this.content = content;
    this.resized();
    this.place();
    this.curves.root.hidden = !track;
    if (track) show(this.curves, track);
    this.updateCards(track ? clip : null);
  }

  /** @param {Clip} clip that is a table */
  showTable(clip) {
    const track = clip.mode === "result" ? clip.track : null;
    const signature = signatureOf(clip);
    if (signature === this.signature) return;
    this.signature = signature;
    this.screen.clock.pause();
    this.curves.root.hidden = true;
    if (track) {
      this.graph.clock.end = track.end;
      show(this.graph, track);
      this.graph.clock.seek(this.graph.clock.time);
    }
    this.updateCards(track ? clip : null);
  }

  /** @param {Clip | null} clip */
  updateCards(clip) {
    if (!clip) {
      this.cards.replaceChildren();
      return;
    }
    const button = (/** @type {string} */ kind, /** @type {string} */ text) => el("button", {
      type: "button", disabled: clip.stage !== null,
      on: { click: () => void this.session.fit(clip, kind, this.description(clip)) } }, text);
    const fits = Object.values(clip.fits);
    const cards = fits.filter((fit) => !fit.error).map((fit) => fitCard(fit, this.kinds[fit.kind],
      clip.truth, (options) => this.play(options),
      button(fit.kind, t("fitAgain"))));
    const balls = clip.track?.hasAngles ? clip.track.count : 0;
    const waiting = Object.values(this.kinds).filter((kind) =>
      kind.is_slow && kind.fewest_balls <= balls && !clip.fits[kind.kind]);
    cards.push(...waiting.map((kind) => waitingCard(kind,
      button(kind.kind, t("fitOnce", { name: tr(kind.title).toLowerCase() })))));
    const refused = fits.filter((fit) => fit.error);
    if (refused.length) cards.push(refusedCard(refused, this.kinds));
    this.cards.replaceChildren(...cards);
  }

  updateTrials() {
    const { clips, trials, desk } = this.session;
    this.trials.hidden = !clips.some((clip) => clip.track);
    // Of a clip that was not tracked: what the server said when it could not read it.
    const named = clips.map((clip) => ({ key: clip.key, name: clip.name,
      reason: clip.track ? clip.noTrial : isSeen(clip) ? null : clip.error }));
    refresh(this.trials, [trials, named, desk.hello?.desk], () => [el("h2", {}, t("trials")),
      el("p", { class: "hint" }, t("trialsHint")),
      trialTable(trials, named, (key) => this.open(clips.find((clip) => clip.key === key))),
      trials.length > 0 && desk.hello ? el("a", { download: "trials.csv",
        href: `api/experiment/trials?desk=${encodeURIComponent(desk.hello.desk)}` },
      t("export_trials")) : ""]);
  }

  /** Return the description of a clip: quantities with places or with columns. */
  description(/** @type {Clip} */ clip) {
    const quantities = this.setup?.quantities(clip);
    if (clip.sheet) return { ...quantities, ...choicesOf(clip.sheet) };
    return { ...quantities, ...toolsOf(clip), ...pivotAndBalls(clip) };
  }

  tracked() {
    const { clip } = this.session;
    if (!clip) return;
    void this.session.track(clip, this.description(clip));
    this.setup?.cancel.focus();
  }

  /** @param {"setup" | "result"} mode */
  mode(mode) {
    const { clip } = this.session;
    if (!clip) return;
    clip.mode = mode;
    this.update();
  }

  /**
   * Take a handle as it was moved.
   * @param {string} name
   */
  corrected(name) {
    const { clip } = this.session;
    if (!clip) return;
    const place = this.handles.places[name];
    if (clip.mode === "result") {
      const { frame } = this.screen;
      const ball = Number(name.slice(-1));
      const others = clip.corrections.filter((c) => c.frame !== frame || c.ball !== ball);
      clip.corrections = [...others, { frame, ball, ...place }].sort((a, b) => a.frame - b.frame);
      this.tools.update(clip);
      return;
    }
    clip.places = { ...clip.places, [name]: place };
    this.confirmed(name);
  }

  /**
   * Take a handle as somebody left it: the place of a pivot or a ball is then no longer a finding.
   * @param {string} name
   */
  confirmed(name) {
    const { clip } = this.session;
    if (!clip || clip.mode === "result") return;
    if (name === "pivot" || name.startsWith("ball")) clip.pointed.add(name);
    this.setUp(clip);
  }

  /** Heed that another frame is on show. */
  moved() {
    this.tools.moved();
    this.place();
  }

  /** Show the handles that belong to the frame on show. */
  place() {
    const { clip } = this.session ?? {};
    if (!clip?.about || !clip.url) return;
    const isHere = clip.stage === null && !this.screen.clock.playing;
    const places = isHere ? handlesOf(clip, this.screen.frame, this.tools.isByHand) : null;
    const shown = this.handles.isOn ? this.handles.places : null;
    const content = [clip.id, clip.mode].join();
    if (content === this.placed && JSON.stringify(places) === JSON.stringify(shown)) return;
    this.placed = content;
    this.handles.radius = (clip.mode === "result" && clip.track?.radius) || clip.radius;
    this.handles.show(places);
  }

  asProposed() {
    const { clip } = this.session;
    if (!clip) return;
    const { ball_2: _, ...places } = clip.places;
    const clickFrame = clip.about?.proposal?.click_frame ?? 0;
    this.changed({ places: { ...places, ...clip.proposed }, pointed: new Set(),
      isPivotOutside: false, clickFrame });
    this.screen.goTo(clickFrame);
  }

  /** @param {number} balls */
  counted(balls) {
    const { clip } = this.session;
    if (!clip?.about) return;
    const { ball_2: second, ...places } = clip.places;
    if (balls === 1) clip.pointed.delete("ball_2");
    const { pivot, ball_1 } = places;
    if (balls === 2) places.ball_2 = second ?? clip.proposed.ball_2
      ?? { u: Math.max(0, 2 * pivot.u - ball_1.u), v: ball_1.v };
    this.changed({ places });
  }

  /** @param {Partial<Clip>} change of the set-up of the clip on show */
  changed(change) {
    const { clip } = this.session;
    if (!clip) return;
    Object.assign(clip, change);
    this.resized();
    this.update();
  }

  /** @param {Partial<import("./sheet.js").Sheet>} change of the choices for the table on show */
  sheetChanged({ part, ...change }) {
    const sheet = this.session.clip?.sheet;
    if (!sheet) return;
    this.changed({ sheet: part === undefined ? { ...sheet, ...change } : chosen(sheet, part) });
  }

  /** @param {string} decimal the sign that a file leaves open */
  signed(decimal) {
    const { clip } = this.session;
    if (!clip) return;
    clip.decimal = decimal;
    if (clip.sheet) this.sheetChanged({ decimal });
    else void this.session.look(clip);
  }

  /** Draw the ball's edge as length and radius say. */
  resized() {
    const length = this.setup?.number("length");
    const radius = this.setup?.number("radius");
    this.handles.ratio = length && radius ? radius / length : 0;
    const isDisc = this.session?.clip?.shape !== "template";
    this.handles.patch = isDisc ? null
      : { half: (this.setup?.number("patch") || 0) / 2, ...this.session.desk.hello?.template };
    this.screen.draw();
  }

  /** @param {Record<string, any>} options in SI units */
  play(options) {
    const known = this.page.registry.options;
    const own = Object.fromEntries(Object.entries(options).filter(([name, value]) => value !== known[name]?.default));
    openState(this.page, { view: "toy", scenario: null, options: textsOf(this.page.registry, own) });
  }
}

/**
 * Options by name, each with the text that its control has.
 * @param {Record<string, string>} controls names of texts
 */
function labelled(controls) {
  return Object.fromEntries(Object.entries(controls).map(([name, text]) => [name, { label: t(text) }]));
}

/**
 * Return a text that changes with what is drawn of a clip.
 * @param {Clip} clip
 */
function signatureOf({ id, mode, tracked, fits, stage }) {
  return JSON.stringify([id, mode, tracked,
    Object.entries(fits).map(([kind, fit]) => [kind, fit.verdict]), stage !== null]);
}

/**
 * @param {Curves} curves
 * @param {import("./track.js").Track} track
 */
function show(curves, track) {
  curves.panels = panelsOf(track);
  curves.show(/** @type {any} */ (track));
}
