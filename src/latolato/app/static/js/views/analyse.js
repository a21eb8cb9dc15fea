/** Analyse: one question about the system and drive of all views, and its answer. */

import { askJson, newest } from "../api.js";
import { AnalysisForm } from "../analysisform.js";
import { Answer } from "../answer.js";
import { el, freshId } from "../dom.js";
import { Form } from "../form.js";
import { JobLine } from "../jobs.js";
import { openLink, withOptions } from "../links.js";
import { t } from "../strings.js";
import { FIRST } from "./play.js";

/** @typedef {import("../main.js").Page} Page */

const KEY = "analyse.";
const WHAT = `${KEY}what`;

export class AnalyseView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {Record<string, any>} */
    this.forms = {};
    this.title = "";
    /** @type {import("../analysisform.js").About | null} */
    this.about = null;
    const id = freshId();
    this.select = el("select", { id, on: { change: () => this.choose(this.select.value) } });
    this.summary = el("p", {});
    this.own = new AnalysisForm((values) => this.keep(values));
    this.job = new JobLine();
    this.go = el("button", { type: "submit", class: "play", disabled: true }, t("ask"));
    const submit = (/** @type {Event} */ event) => {
      event.preventDefault();
      void this.ask();
    };
    const question = el("form", { class: "card form", on: { submit } },
      el("div", { class: "field preset" }, el("label", { for: id }, t("question")), this.select),
      this.summary, this.own.root, el("div", { class: "row" }, this.go), this.job.root);
    const laws = el("form", { class: "form", on: {
      submit: (/** @type {Event} */ event) => event.preventDefault() } });
    this.laws = new Form(laws, page.registry, page.store);
    this.of = el("p", { class: "notes" });
    this.answer = el("div", {}, el("section", { class: "card" }, el("p", {}, t("askHint"))));
    this.root = el("div", { class: "view split analyse" },
      el("aside", { class: "side" }, question,
        el("details", { class: "card" }, el("summary", {}, t("lawsOfQuestion")), laws)),
      el("div", { class: "main" }, this.of, this.answer));
    this.refresh = newest(() => this.look());
    /** @type {() => void} */
    this.unsubscribe = () => {};
  }

  /** Return what all views are about. */
  get asked() {
    const { scenario, options } = this.page.store.state;
    return { scenario: scenario || (options.system ? null : FIRST), options };
  }

  /** Return the name of the analysis. */
  get what() {
    const name = this.page.store.state.extra[WHAT];
    return name in this.forms ? name : Object.keys(this.forms)[0];
  }

  show() {
    this.unsubscribe = this.page.store.subscribe((_, changed) => {
      if (changed !== "extra") this.refresh(null);
    });
    this.refresh(null);
  }

  hide() {
    this.unsubscribe();
    this.job.stop();
  }

  /** Read what the server says of the system and drive, and show the fields. */
  async look() {
    if (!this.select.options.length) {
      this.forms = await askJson("/api/analyses");
      this.select.replaceChildren(...Object.entries(this.forms).map(([name, form]) =>
        el("option", { value: name }, form.title)));
    }
    try {
      this.about = await askJson("/api/asked", this.asked);
      this.laws.show(/** @type {any} */ (this.about).options);
      const { options, title } = /** @type {any} */ (this.about);
      const { registry } = this.page;
      this.title = title || registry.systems[options.system].title;
      this.of.textContent = t("questionOf", { title: title || t("presetNone"),
        system: registry.systems[options.system].title,
        drive: registry.drives[options.drive].title });
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      this.laws.error(error.message, /** @type {any} */ (error).field ?? null);
      return;
    }
    this.build();
  }

  build() {
    if (!this.about) return;
    const form = this.forms[this.what];
    this.select.value = this.what;
    this.summary.textContent = form.summary;
    this.summary.title = form.notes;
    const { extra } = this.page.store.state;
    const given = Object.fromEntries(Object.keys(form.options).filter((name) => KEY + name in extra)
      .map((name) => [name, extra[KEY + name]]));
    this.own.build(form.options, this.about, given);
    this.go.disabled = false;
    this.root.dataset.form = this.what;
  }

  /** @param {string} name */
  choose(name) {
    this.setExtra({ [WHAT]: name });
    this.job.stop();
    this.job.error.hidden = true;
    this.build();
  }

  /** @param {Record<string, string>} values */
  keep(values) {
    const own = Object.entries(values).map(([name, value]) => [KEY + name, value]);
    const built = "parameter" in values && !("low" in values);
    this.setExtra({ [WHAT]: this.what, ...Object.fromEntries(own) });
    if (built) this.build();
  }

  /** @param {Record<string, string>} own all that this view keeps in the address */
  setExtra(own) {
    const { extra } = this.page.store.state;
    const others = Object.entries(extra).filter(([name]) => !name.startsWith(KEY));
    this.page.store.set({ extra: { ...Object.fromEntries(others), ...own } }, "extra");
  }

  /** Ask the server and show the answer. */
  async ask() {
    const values = this.own.values();
    this.keep(values);
    this.own.error(null);
    const asked = this.asked;
    const title = t("answerOf", { name: this.forms[this.what].title, title: this.title });
    const block = await this.job.run("/ws/analyse",
      { ...asked, analysis: this.what, given: values });
    if (!block) {
      const { error } = this.job;
      if (!error.hidden && this.own.error(error.textContent)) {
        error.hidden = true;
        error.textContent = "";
      }
      return;
    }
    const answer = new Answer(block, title, (point) => this.take(asked.scenario, point));
    this.answer.replaceChildren(answer.root);
    // On a narrow page the answer stands below the question.
    if (answer.root.getBoundingClientRect().top > window.innerHeight) answer.root.scrollIntoView();
    this.root.dataset.answers = String(Number(this.root.dataset.answers ?? 0) + 1);
  }

  /**
   * Load the values of a point into what all views are about; returns what is said of it.
   * @param {string | null} scenario
   * @param {Record<string, string>} point
   */
  take(scenario, point) {
    const { store } = this.page;
    const options = withOptions(store.state.options, point);
    store.set({ scenario, options });
    const values = Object.entries(point).map(([name, text]) =>
      `${name.replace(/_/g, " ")} ${text}`);
    return el("span", {}, `${t("pointTaken", { values: values.join(", ") })} `,
      openLink(this.page, { view: "play", scenario, options }, t("openCase")));
  }
}
