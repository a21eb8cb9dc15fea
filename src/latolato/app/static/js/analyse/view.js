/** Analyse: one question about the system and drive of all views, and its answer. */

import { askJson, newest, Offline } from "../shared/api.js";
import { el, freshId } from "../shared/dom.js";
import { findingPlace, showFinding } from "../shared/finding.js";
import { Form } from "../shared/form.js";
import { JobLine } from "../shared/jobs.js";
import { heldOptions, withLaws } from "../shared/laws.js";
import { withOptions } from "../shared/links.js";
import { spanText } from "../shared/left.js";
import { presetField } from "../shared/presets.js";
import { leaveOut } from "../shared/reading.js";
import { FIRST } from "../shared/state.js";
import { inWords } from "../shared/words.js";
import { ENGLISH, t, tr } from "../strings.js";
import { Answer, pictureCard } from "./answer.js";
import { AnalysisForm } from "./form.js";
import { PointRun } from "./point.js";
import { QuestionList, translateQuestions } from "./questions.js";

/** @typedef {import("../shared/state.js").Page} Page */
/** @typedef {import("./questions.js").Asking} Asking */

const KEY = "analyse.";
const WHAT = `${KEY}what`;
// A link with this part asks its question however long the answer takes.
const ASK = `${KEY}ask`;
// What takes no longer is asked without being told to.
const QUICK = 10; // s
// Whoever moves a slider has come to a stop after this time.
const PAUSE = 500; // ms
const RETRY = 1000; // ms

export class AnalyseView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {Record<string, Asking>} */
    this.forms = {};
    /** @type {import("./form.js").About | null} */
    this.about = null;
    this.turn = 0;
    this.timer = 0;
    this.working = "";
    this.list = new QuestionList((name) => this.choose(name));
    this.own = new AnalysisForm(page.registry, (changes) => this.keep(changes));
    this.job = new JobLine();
    this.point = new PointRun(page, (request) => page.store.set(request));
    this.presets = presetField(page);
    const id = freshId();
    // Outside of its form, where the answer will stand.
    this.go = el("button", { type: "submit", class: "play", form: id }, t("compute"));
    this.cost = el("span", { class: "soft", role: "status" });
    this.title = el("h2", { class: "asks" });
    this.of = el("p", { class: "hint" });
    this.notice = el("p", { class: "notice", role: "status", hidden: true });
    this.finding = findingPlace();
    this.unfit = el("div", { class: "unfit-note", hidden: true });
    this.asking = el("div", { class: "row asking" }, this.go, this.cost);
    const submit = (/** @type {Event} */ event) => {
      event.preventDefault();
      this.working = "";
      void this.consider(true);
    };
    this.fields = el("details", { class: "card settings-of" }, el("summary", {}, t("settings")),
      el("form", { id, class: "form", on: { submit } }, this.own.root));
    const laws = el("form", { class: "form", on: {
      submit: (/** @type {Event} */ event) => event.preventDefault() } });
    this.laws = new Form(laws, page.registry, page.store);
    this.answer = el("div", {});
    this.root = el("div", { class: "view split analyse" },
      el("aside", { class: "side" }, el("section", { class: "card" }, this.presets.field),
        el("details", { class: "card laws" }, el("summary", {}, t("lawsOfQuestion")), laws),
        this.fields, this.list.root),
      el("div", { class: "main" }, el("section", { class: "card question" }, this.notice, this.title,
        this.of, this.unfit, this.finding, this.asking, this.job.root), this.answer));
    this.refresh = newest(() => this.look());
    /** @type {() => void} */
    this.unsubscribe = () => {};
  }

  /** The run that all views show: its scenario and options. */
  get request() {
    const { scenario, options } = this.page.store.state;
    return { scenario: scenario || (options.system ? null : FIRST), options };
  }

  /** Return the name of the analysis. */
  get what() {
    const name = this.page.store.state.extra[WHAT];
    return name in this.forms ? name : this.about?.first ?? Object.keys(this.forms)[0];
  }

  show() {
    this.unsubscribe = this.page.store.subscribe((_, changed) => {
      if (changed === "extra") return;
      clearTimeout(this.timer);
      this.timer = window.setTimeout(() => this.refresh(null), changed === "options" ? PAUSE : 0);
    });
    this.refresh(null);
  }

  hide() {
    this.unsubscribe();
    clearTimeout(this.timer);
    this.turn += 1;
    this.working = "";
    this.job.stop();
    this.point.rest();
  }

  /** Read what the server says about the system and drive, and show the fields. */
  async look() {
    const { registry } = this.page;
    try {
      if (!Object.keys(this.forms).length) {
        this.forms = await askJson("api/analyses");
        translateQuestions(this.forms);
        this.list.build(this.forms);
      }
      const about = await askJson("api/analyses/about", this.request);
      for (const each of Object.values(about.parameters)) each.label = tr(each.label);
      this.about = about;
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (error instanceof Offline) {
        this.tell(t("offline"));
        this.timer = window.setTimeout(() => this.refresh(null), RETRY);
        return;
      }
      this.tell(error.message);
      this.laws.error(error.message, /** @type {any} */ (error).field ?? null);
      return;
    }
    const about = /** @type {import("./form.js").About} */ (this.about);
    this.presets.show(this.request.scenario);
    this.laws.show(about.options);
    this.of.textContent = t("questionOf", { title: tr(about.title) || t("presetNone"),
      system: tr(registry.systems[about.options.system].title),
      drive: tr(registry.drives[about.options.drive].title) });
    this.build();
  }

  /** @param {string} text of the line above the question; none hides it */
  tell(text) {
    this.notice.textContent = text;
    this.notice.hidden = text === "";
  }

  build() {
    if (!this.about) return;
    const form = this.forms[this.what];
    const { extra } = this.page.store.state;
    const kept = Object.keys(extra).filter((name) => name.startsWith(KEY)
      && name !== WHAT && name !== ASK);
    const strange = kept.filter((name) => !Object.hasOwn(form.options, name.slice(KEY.length)));
    const isAsked = !(WHAT in extra) || Object.hasOwn(this.forms, extra[WHAT]);
    leaveOut(this.page, Object.fromEntries([
      ...(isAsked ? [] : [[WHAT, { text: t("unknownQuestion", { name: extra[WHAT] }) }]]),
      ...strange.map((name) => [name, { text: t("unknownSetting", { name: name.slice(KEY.length) }) }])]));
    this.tell("");
    this.list.show(this.what, this.about.unfit);
    this.title.textContent = form.title;
    const typed = Object.fromEntries(Object.keys(form.options).filter((name) => KEY + name in extra)
      .map((name) => [name, extra[KEY + name]]));
    const why = this.about.unfit[this.what];
    this.showUnfit(why);
    this.fields.hidden = why !== undefined;
    this.own.build(this.what, form, this.about, typed);
    this.root.dataset.form = this.what;
    if (this.root.dataset.answered !== this.what || why) this.clear();
    if (!why) void this.consider(extra[ASK] === "1");
  }

  /** Take the answer away; its place says what will stand there. */
  clear() {
    const isFit = !(this.what in (this.about?.unfit ?? {}));
    this.finding.hidden = !isFit;
    showFinding(this.finding, t("answerHere"), false);
    this.answer.replaceChildren(...(isFit ? [pictureCard(this.forms[this.what])] : []));
    this.asking.hidden = true;
    this.point.rest();
    this.point.root.hidden = true;
  }

  /** Offer to compute what was not asked or has no answer. */
  offer() {
    this.clear();
    this.asking.hidden = false;
  }

  /**
   * Say why a question cannot be asked of this system, and offer one of which it can.
   * @param {string | undefined} why
   */
  showUnfit(why) {
    this.unfit.hidden = why === undefined;
    if (why === undefined || !this.about) return;
    this.job.stop();
    const { registry, store } = this.page;
    const { system, drive } = this.about.options;
    const shaken = registry.drives[drive].periodic ? drive : "harmonic";
    const pair = registry.systems[system].contacts;
    const fitting = why.includes(registry.systems.latolato.title) ? "latolato"
      : pair && shaken === drive ? "pendulum" : system === "mathieu" ? "pendulum" : system;
    const text = t(fitting === "latolato" ? "unfitToy"
      : fitting === system ? "unfitDrive" : "unfitSystem");
    const { options } = this.about;
    const kinds = { system: fitting, drive: shaken };
    this.unfit.replaceChildren(el("p", { lang: ENGLISH }, why), el("button", { type: "button", on: {
      click: () => store.set({ scenario: this.request.scenario, options: withLaws(registry,
        heldOptions(registry, store.state.options, options, { system }, kinds), options, fitting,
        shaken) }) } }, text));
  }

  /** @param {string} name */
  choose(name) {
    this.setExtra({ [WHAT]: name });
    this.build();
    if (this.title.getBoundingClientRect().top < 0 || window.innerWidth < 800)
      this.title.scrollIntoView({ block: "center" });
  }

  /** @param {Record<string, string>} changes */
  keep(changes) {
    const own = Object.entries(changes).map(([name, value]) => [KEY + name, value]);
    this.setExtra({ [WHAT]: this.what, ...Object.fromEntries(own) });
    if ("low" in this.own.fields && !("low" in this.own.inputs)) this.build();
    else void this.consider(false);
  }

  /** @param {Record<string, string>} own all that this view keeps in the address */
  setExtra(own) {
    const { extra } = this.page.store.state;
    const others = Object.entries(extra).filter(([name]) => !name.startsWith(KEY));
    this.page.store.set({ extra: { ...Object.fromEntries(others), ...own } }, "extra");
  }

  /**
   * Ask what is typed, if it is soon answered or was wanted; else say how long it takes. A question
   * whose time was never measured is begun, and ended again if its first part shows that it is slow.
   * @param {boolean} isWanted
   */
  async consider(isWanted) {
    const values = this.own.values();
    const question = { ...this.request, analysis: this.what, settings: values };
    const key = JSON.stringify(question);
    if (this.working === key) return;
    this.working = key;
    this.turn += 1;
    const { turn } = this;
    this.job.stop();
    this.job.error.hidden = true;
    this.own.error(null);
    this.cost.textContent = "";
    try {
      const { seconds, refused } = await askJson("api/analyses/cost", question);
      if (turn !== this.turn) return;
      if (refused) this.refuse(refused);
      else if (isWanted || seconds === null || seconds <= QUICK)
        await this.ask(question, seconds, turn, isWanted || seconds !== null);
      else this.tellCost(seconds);
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (turn === this.turn) this.refuse(error instanceof Offline ? t("offline") : error.message);
    }
  }

  /**
   * Say how long an answer takes, which waits for Compute.
   * @param {number} seconds as measured
   */
  tellCost(seconds) {
    this.offer();
    this.cost.textContent = t("askCost", { time: spanText(seconds) });
  }

  /** @param {string} text why there is no answer */
  refuse(text) {
    this.age(false);
    this.offer();
    if (this.own.error(text)) {
      this.job.error.hidden = true;
      this.fields.open = true;
    }
    else this.job.refuse(inWords(text, this.own.words));
  }

  /** @param {boolean} isOld whether what is on show answers an older question */
  age(isOld) {
    for (const place of [this.finding, this.answer]) place.classList.toggle("stale", isOld);
  }

  /**
   * Ask the server and show the answer.
   * @param {{scenario: string | null, options: Record<string, string>, analysis: string,
   *   settings: Record<string, string>}} question
   * @param {number | null} seconds that it takes, if that was measured before
   * @param {number} turn
   * @param {boolean} isWanted however long it takes
   */
  async ask(question, seconds, turn, isWanted) {
    this.age(true);
    this.asking.hidden = true;
    /** @type {number | null} */
    let slow = null;
    const block = await this.job.run("ws/analyse", question, { expected: seconds, timed: (all) => {
      if (isWanted || all <= QUICK) return;
      slow = all;
      this.job.stop();
    } });
    if (turn !== this.turn) return;
    if (!block) {
      const { error } = this.job;
      this.age(false);
      if (slow !== null) this.tellCost(slow);
      else if (error.hidden) this.offer();
      else this.refuse(error.textContent ?? "");
      this.working = "";
      return;
    }
    this.age(false);
    this.clear();
    const called = this.own.words;
    const answer = new Answer(block, this.forms[question.analysis], (text) => inWords(text, called), (values, words) =>
      void this.point.show({ scenario: question.scenario,
        options: withOptions(this.page.registry, question.options, values) }, "initial_angle" in values ? t("pointSaid", { values: words })
        : t("pointSaidStart", { values: words })));
    answer.after.append(this.point.root);
    showFinding(this.finding, block.about.verdict, true);
    this.answer.replaceChildren(answer.root);
    this.root.dataset.answered = question.analysis;
    this.root.dataset.answers = String(Number(this.root.dataset.answers ?? 0) + 1);
  }
}
