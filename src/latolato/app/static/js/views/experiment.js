/** Experiment: a video is uploaded, tracked, fitted, and compared with what is computed. */

import { Curves } from "../curves.js";
import { el, refresh } from "../dom.js";
import { dropCard, exportsCard, filmList } from "../film/cards.js";
import { Handles } from "../film/handles.js";
import { fitCard, refusedCard, trialTable, waitingCard } from "../film/results.js";
import { Screen } from "../film/screen.js";
import { Session } from "../film/session.js";
import { Setup } from "../film/setup.js";
import { panelsOf } from "../film/track.js";
import { textOf } from "../laws.js";
import { t } from "../strings.js";
import { short } from "../units.js";

/** @typedef {import("../main.js").Page} Page */
/** @typedef {import("../film/session.js").Film} Film */

/** What of an example's truth somebody would have measured before. */
const KNOWN = ["length", "radius", "mass"];
/** A link with this part films an example and measures it. */
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
    /** @type {Record<string, import("../film/desk.js").FitKind>} */
    this.kinds = {};
    this.shown = "";
    this.drop = el("div", { class: "film-drop" });
    this.list = el("div", { class: "film-list" });
    this.form = el("div", { class: "film-form" });
    this.exports = el("div", { class: "film-exports" });
    this.welcome = el("div", { class: "welcome" },
      el("section", { class: "card steps" }, el("h2", {}, t("steps")),
        el("ol", {}, ...["step1", "step2", "step3"].map((s) => el("li", {}, t(s))))));
    this.notes = el("p", { class: "notes", role: "status" });
    this.cards = el("div", { class: "cards" });
    this.player = el("div", { class: "player" }, this.screen.root, curves, this.cards);
    this.trials = el("section", { class: "card film-trials" });
    this.side = el("aside", { class: "side" }, this.list, this.form, this.exports);
    this.root = el("div", { class: "view split experiment", on: {
      dragover: (/** @type {DragEvent} */ e) => this.dragged(e, true),
      dragleave: (/** @type {DragEvent} */ e) => this.dragged(e, false),
      drop: (/** @type {DragEvent} */ e) => this.dropped(e),
    } },
    this.side, el("div", { class: "main" }, this.welcome, this.notes, this.player, this.trials));
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
    const { desk, film } = this.session;
    if (desk.hello && !this.setup) this.build(desk.hello);
    const state = film?.stage ?? film?.mode ?? "empty";
    this.root.dataset.state = state;
    this.root.classList.toggle("empty", !film);
    const place = film ? this.side : this.welcome;
    if (this.drop.parentElement !== place) place.append(this.drop);
    const { films } = this.session;
    refresh(this.list, [films.map((f) => [f.id, f.stage !== null]), film?.id], () =>
      [filmList(this.session, (each) => this.open(each))]);
    this.form.hidden = !film;
    if (film) this.setup?.update(film);
    const isKept = this.session.isKept(film);
    refresh(this.exports,
      [film?.id, film?.tracked, film?.stage !== null, [...film?.files ?? []], isKept],
      () => (film?.track && isKept ? [exportsCard(this.session, film)] : []));
    this.welcome.hidden = film !== null;
    this.player.hidden = !film?.about || !film.url;
    this.player.classList.toggle("alone", film?.mode === "setup");
    const isGone = desk.epoch > 0 && !desk.hello;
    const warnings = film?.mode === "result" ? film.warnings : [];
    this.notes.textContent = [...(isGone ? [t("offline")] : []),
      ...warnings.map((text) => t("warning", { text }))].join(" ");
    if (film?.about && film.url) this.showFilm(film);
    this.updateTrials();
  }

  /** @param {Film | undefined} film */
  open(film) {
    this.session.film = film ?? this.session.film;
    this.update();
  }

  /** @param {import("../film/desk.js").Hello} hello */
  build(hello) {
    const setup = new Setup(this.page.store, hello.fields, {
      changed: () => this.resized(),
      count: (balls) => this.counted(balls),
      track: () => this.tracked(),
      mode: (mode) => this.mode(mode),
      reset: () => this.asFound(),
      cancel: () => this.session.film?.cancel(),
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
    const film = await this.session.example(kind);
    if (!film || this.session.film !== film) return;
    const values = KNOWN.filter((name) => name in film.truth).map((name) => {
      const unit = this.page.registry.options[name].units[0];
      return [name, `${short(film.truth[name] / unit.size)} ${unit.name}`];
    });
    this.setup?.fill(Object.fromEntries(values));
    this.resized();
  }

  /** @param {Film} film */
  showFilm(film) {
    const track = film.mode === "result" ? film.track : null;
    const about = /** @type {NonNullable<Film["about"]>} */ (film.about);
    const signature = JSON.stringify([film.id, film.mode, film.tracked,
      Object.entries(film.fits).map(([k, f]) => [k, f.verdict]), film.stage !== null]);
    if (signature === this.shown) return;
    this.shown = signature;
    this.screen.show({ ...about, url: film.url }, track);
    this.handles.radius = film.radius;
    this.handles.show(track ? null : film.places);
    if (!track) this.screen.clock.go(0);
    this.resized();
    this.curves.root.hidden = !track;
    if (track) {
      this.curves.panels = panelsOf(track);
      for (const task of this.curves.show(/** @type {any} */ (track))) task();
    }
    this.updateCards(track ? film : null);
  }

  /** @param {Film | null} film */
  updateCards(film) {
    if (!film) {
      this.cards.replaceChildren();
      return;
    }
    const button = (/** @type {string} */ kind, /** @type {string} */ text) => el("button", {
      type: "button", disabled: film.stage !== null,
      on: { click: () => void this.session.fit(film, kind, this.description(film)) } }, text);
    const fits = Object.values(film.fits);
    const cards = fits.filter((fit) => !fit.error).map((fit) => fitCard(fit, this.kinds[fit.kind],
      film.truth, this.page.registry, (options) => this.play(options),
      button(fit.kind, t("fitAgain"))));
    const balls = film.track?.hasAngles ? film.track.count : 0;
    const waiting = Object.values(this.kinds).filter((kind) =>
      kind.is_slow && kind.fewest_balls <= balls && !film.fits[kind.kind]);
    cards.push(...waiting.map((kind) => waitingCard(kind,
      button(kind.kind, t("fitOnce", { name: kind.title.toLowerCase() })))));
    const refused = fits.filter((fit) => fit.error);
    if (refused.length) cards.push(refusedCard(refused, this.kinds));
    this.cards.replaceChildren(...cards);
  }

  updateTrials() {
    const { films, trials, desk } = this.session;
    this.trials.hidden = !films.some((film) => film.track);
    // Of a film that was not tracked: what the server said when it could not read it.
    const named = films.map(({ key, name, track, noTrial, about, error }) => ({ key, name,
      reason: track ? noTrial : about ? null : error }));
    refresh(this.trials, [trials, named, desk.hello?.desk], () => [el("h2", {}, t("trials")),
      el("p", { class: "hint" }, t("trialsHint")),
      trialTable(trials, named, (key) => this.open(films.find((film) => film.key === key))),
      trials.length > 0 && desk.hello ? el("a", { download: "trials.csv",
        href: `api/trials?desk=${encodeURIComponent(desk.hello.desk)}` },
      t("export_trials")) : ""]);
  }

  /** Return the description of a film: places, quantities, and who placed the handles. */
  description(/** @type {Film} */ film) {
    const { pivot, ball_1, ball_2 } = film.places;
    const pair = (/** @type {import("../film/handles.js").Place} */ p) => [p.u, p.v];
    return { ...this.setup?.values, is_proposed: film.isProposed,
      pivot: this.setup?.unseen?.checked ? null : pair(pivot),
      balls: [ball_1, ball_2].filter(Boolean).map(pair) };
  }

  tracked() {
    const { film } = this.session;
    if (!film) return;
    void this.session.track(film, this.description(film));
    this.setup?.cancel.focus();
  }

  /** @param {"setup" | "result"} mode */
  mode(mode) {
    const { film } = this.session;
    if (!film) return;
    film.mode = mode;
    this.update();
  }

  /** Take the handles as they were moved. */
  corrected() {
    const { film } = this.session;
    if (!film) return;
    film.places = { ...this.handles.places };
    film.isProposed = false;
    this.setup?.update(film);
  }

  asFound() {
    const { film } = this.session;
    if (!film) return;
    film.places = { ...film.proposed };
    film.isProposed = true;
    this.handles.show(film.places);
    this.setup?.update(film);
  }

  /** @param {number} balls */
  counted(balls) {
    const { film } = this.session;
    if (!film?.about) return;
    const { pivot, ball_1 } = film.places;
    film.places = { pivot, ball_1 };
    if (balls === 2) film.places.ball_2 = film.proposed.ball_2
      ?? { u: Math.max(0, 2 * pivot.u - ball_1.u), v: ball_1.v };
    film.isProposed = false;
    this.handles.show(film.places);
    this.setup?.update(film);
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
    this.page.store.set({ view: "play", scenario: null, options: texts }, "view");
  }
}
