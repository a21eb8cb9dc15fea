/** Experiment: a video is uploaded, tracked, fitted, and compared with what is computed. */

import { Curves } from "../shared/curves.js";
import { el, refresh } from "../shared/dom.js";
import { findingPlace, showFinding } from "../shared/finding.js";
import { textOf } from "../shared/laws.js";
import { openState } from "../shared/links.js";
import { short } from "../shared/units.js";
import { t } from "../strings.js";
import { answerNumbers, clipList, dropCard, exportsCard, guideCard } from "./cards.js";
import { Handles } from "./handles.js";
import { fitCard, refusedCard, trialTable, waitingCard } from "./results.js";
import { Screen } from "./screen.js";
import { Session } from "./session.js";
import { Setup } from "./setup.js";
import { panelsOf } from "./track.js";

/** @typedef {import("../shared/state.js").Page} Page */
/** @typedef {import("./session.js").Clip} Clip */

/** What of an example's truth somebody would have measured before, by the fields. */
const KNOWN = { length: "centre_length", radius: "radius", mass: "mass" };
/** A link with this part clips an example and measures it. */
const LINKED = "experiment.example";

export class ExperimentView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    this.screen = new Screen();
    this.handles = new Handles(this.screen, () => this.corrected());
    const curves = el("div", { class: "curves" });
    this.curves = new Curves(curves, this.screen.clock, []);
    /** @type {Setup | null} */
    this.setup = null;
    /** @type {Record<string, import("./desk.js").FitKind>} */
    this.kinds = {};
    this.signature = "";
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
    this.player = el("div", { class: "player" }, this.screen.root, curves, this.cards);
    this.trials = el("section", { class: "card clip-trials" });
    this.side = el("aside", { class: "side" }, this.list, this.form);
    this.root = el("div", { class: "view split experiment", on: {
      dragover: (/** @type {DragEvent} */ e) => this.dragged(e, true),
      dragleave: (/** @type {DragEvent} */ e) => this.dragged(e, false),
      drop: (/** @type {DragEvent} */ e) => this.dropped(e),
    } },
    this.side, el("div", { class: "main" }, this.welcome, this.said, this.player, this.trials, this.exports));
    this.session = new Session(() => this.update());
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
    if (clip) this.setup?.update(clip);
    const isKept = this.session.isKept(clip);
    refresh(this.exports,
      [clip?.id, clip?.tracked, clip?.stage !== null, [...clip?.files ?? []], isKept],
      () => (clip?.track && isKept ? [exportsCard(this.session, clip)] : []));
    this.welcome.hidden = clip !== null;
    this.player.hidden = !clip?.about || !clip.url;
    this.player.classList.toggle("alone", clip?.mode === "setup");
    const isGone = desk.epoch > 0 && !desk.hello;
    const warnings = clip?.mode === "result" ? clip.warnings : [];
    this.notes.textContent = [...(isGone ? [t("offline")] : []),
      ...warnings.map((text) => t("warning", { text }))].join(" ");
    const isAnswer = clip?.mode === "result";
    const text = isAnswer ? clip.finding : t("findingHere");
    refresh(this.numbers, [clip?.id, clip?.tracked, isAnswer],
      () => (isAnswer && clip.answer.length > 0 ? [answerNumbers(clip.answer)] : []));
    this.finding.hidden = !clip?.about;
    if (this.shown !== text) showFinding(this.finding, text, isAnswer);
    this.shown = text;
    this.said.hidden = this.finding.hidden && this.notes.textContent === "";
    if (clip?.about && clip.url) this.showClip(clip);
    this.updateTrials();
  }

  /** @param {Clip | undefined} clip */
  open(clip) {
    this.session.clip = clip ?? this.session.clip;
    this.update();
  }

  /** @param {import("./desk.js").Hello} hello */
  build(hello) {
    const setup = new Setup(this.page, hello.fields, {
      changed: () => this.resized(),
      count: (balls) => this.counted(balls),
      track: () => this.tracked(),
      mode: (mode) => this.mode(mode),
      reset: () => this.asProposed(),
      cancel: () => this.session.clip?.cancel(),
      outside: (isOutside) => this.outside(isOutside),
    });
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
    const values = Object.entries(KNOWN).map(([name, known]) => {
      const unit = this.page.registry.options[name].units[0];
      return [name, `${short(clip.truth[known] / unit.size)} ${unit.name}`];
    });
    this.setup?.fill(Object.fromEntries(values));
    this.resized();
  }

  /** @param {Clip} clip */
  showClip(clip) {
    const track = clip.mode === "result" ? clip.track : null;
    const about = /** @type {NonNullable<Clip["about"]>} */ (clip.about);
    const signature = JSON.stringify([clip.id, clip.mode, clip.tracked,
      Object.entries(clip.fits).map(([k, f]) => [k, f.verdict]), clip.stage !== null]);
    if (signature === this.signature) return;
    this.signature = signature;
    this.screen.show({ ...about, url: clip.url }, track);
    this.handles.radius = clip.radius;
    this.handles.show(track ? null : handlesOf(clip));
    if (!track) this.screen.clock.go(0);
    this.resized();
    this.curves.root.hidden = !track;
    if (track) {
      this.curves.panels = panelsOf(track);
      for (const task of this.curves.show(/** @type {any} */ (track))) task();
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
      clip.truth, this.page.registry, (options) => this.play(options),
      button(fit.kind, t("fitAgain"))));
    const balls = clip.track?.hasAngles ? clip.track.count : 0;
    const waiting = Object.values(this.kinds).filter((kind) =>
      kind.is_slow && kind.fewest_balls <= balls && !clip.fits[kind.kind]);
    cards.push(...waiting.map((kind) => waitingCard(kind,
      button(kind.kind, t("fitOnce", { name: kind.title.toLowerCase() })))));
    const refused = fits.filter((fit) => fit.error);
    if (refused.length) cards.push(refusedCard(refused, this.kinds));
    this.cards.replaceChildren(...cards);
  }

  updateTrials() {
    const { clips, trials, desk } = this.session;
    this.trials.hidden = !clips.some((clip) => clip.track);
    // Of a clip that was not tracked: what the server said when it could not read it.
    const named = clips.map(({ key, name, track, noTrial, about, error }) => ({ key, name,
      reason: track ? noTrial : about ? null : error }));
    refresh(this.trials, [trials, named, desk.hello?.desk], () => [el("h2", {}, t("trials")),
      el("p", { class: "hint" }, t("trialsHint")),
      trialTable(trials, named, (key) => this.open(clips.find((clip) => clip.key === key))),
      trials.length > 0 && desk.hello ? el("a", { download: "trials.csv",
        href: `api/experiment/trials?desk=${encodeURIComponent(desk.hello.desk)}` },
      t("export_trials")) : ""]);
  }

  /** Return the description of a clip: places, quantities, and who placed the handles. */
  description(/** @type {Clip} */ clip) {
    const { pivot, ball_1, ball_2 } = clip.places;
    const pair = (/** @type {import("./handles.js").Place} */ p) => [p.u, p.v];
    return { ...this.setup?.values, is_proposed: clip.isProposed,
      pivot: clip.isPivotOutside ? "outside" : pair(pivot),
      balls: [ball_1, ball_2].filter(Boolean).map(pair) };
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

  /** Take the handles as they were moved. */
  corrected() {
    const { clip } = this.session;
    if (!clip) return;
    clip.places = { ...clip.places, ...this.handles.places };
    clip.isProposed = false;
    this.setup?.update(clip);
  }

  asProposed() {
    const { clip } = this.session;
    if (!clip) return;
    clip.places = { ...clip.proposed };
    clip.isProposed = true;
    clip.isPivotOutside = false;
    this.handles.show(handlesOf(clip));
    this.setup?.update(clip);
  }

  /** @param {number} balls */
  counted(balls) {
    const { clip } = this.session;
    if (!clip?.about) return;
    const { pivot, ball_1 } = clip.places;
    clip.places = { pivot, ball_1 };
    if (balls === 2) clip.places.ball_2 = clip.proposed.ball_2
      ?? { u: Math.max(0, 2 * pivot.u - ball_1.u), v: ball_1.v };
    clip.isProposed = false;
    this.handles.show(handlesOf(clip));
    this.setup?.update(clip);
  }

  /** @param {boolean} isOutside whether the pivot is outside of the picture */
  outside(isOutside) {
    const { clip } = this.session;
    if (!clip) return;
    clip.isPivotOutside = isOutside;
    this.handles.show(handlesOf(clip));
    this.setup?.update(clip);
  }

  /** Draw the ball's edge as length and radius say. */
  resized() {
    const length = this.setup?.number("length");
    const radius = this.setup?.number("radius");
    this.handles.ratio = length && radius ? radius / length : 0;
    this.screen.draw();
  }

  /** @param {Record<string, any>} options in SI units */
  play(options) {
    const known = this.page.registry.options;
    const texts = Object.fromEntries(Object.entries(options)
      .filter(([name, value]) => value !== known[name]?.default)
      .map(([name, value]) => [name, textOf(known[name], value)]));
    openState(this.page, { view: "play", scenario: null, options: texts });
  }
}

/**
 * Return the places that have a handle: a pivot outside of the picture has none.
 * @param {Clip} clip
 */
function handlesOf({ places: { pivot, ...balls }, isPivotOutside }) {
  return isPivotOutside ? balls : { pivot, ...balls };
}
