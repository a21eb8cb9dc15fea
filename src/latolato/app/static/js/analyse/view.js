/** Analyse: one analysis of the system and drive of all views, and its result. */

import { askJson, Offline, Refusal } from "../page/api.js";
import { el, freshId } from "../page/dom.js";
import { Form } from "../page/form.js";
import { fileOf, JobLine } from "../page/jobs.js";
import { openLink } from "../page/links.js";
import { presetField } from "../page/presets.js";
import { leaveOut } from "../page/link_parts.js";
import { inPagesWords } from "../page/refusals.js";
import { FIRST } from "../page/state.js";
import { inWords } from "../page/option_labels.js";
import { t, tr } from "../strings.js";
import { ResultCard } from "./result.js";
import { ArgumentForm } from "./arguments.js";
import { openOverMap } from "./over_map.js";

/** @typedef {import("../page/state.js").Page} Page */
/** @typedef {{title: string, summary: string, notes: string, reading: string, first: string[],
 *   run: string[], options: Record<string, import("./arguments.js").Argument>}} Analysis */

const KEY = "analyse.";
const WHAT = `${KEY}what`;
// The analysis whose result is drawn over maps too.
const CURVE = "bifurcation_curve";
// Whoever opens a link with this part need not press Compute.
const ASK = `${KEY}ask`;
// Whoever moves a slider has come to a stop after this time.
const PAUSE = 500; // ms
const RETRY = 1000; // ms

export class AnalyseView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {Record<string, Analysis>} */
    this.analyses = {};
    /** @type {import("./arguments.js").SystemAbout | null} */
    this.about = null;
    this.timer = 0;
    /** What was asked last, to tell whether the result on show is still of what the page says. */
    this.asked = "";
    this.isOpening = false;
    this.own = new ArgumentForm(page.registry, (changes) => this.keep(changes));
    this.job = new JobLine();
    this.presets = presetField(page);
    const id = freshId();
    this.select = el("select", { id, on: { change: () => this.setExtra({ [WHAT]: this.select.value }) } });
    this.summary = el("p", { class: "hint" });
    this.notes = el("p", { class: "hint" });
    this.more = el("details", { class: "about", hidden: true }, el("summary", {}, t("analysisAbout")), this.notes);
    this.notice = el("p", { class: "notice", role: "status", hidden: true });
    this.go = el("button", { type: "submit", class: "play" }, t("compute"));
    const submit = (/** @type {Event} */ event) => {
      event.preventDefault();
      // What is wrong stands at its field.
      if (!this.own.isRefused) void this.compute();
    };
    this.fields = el("form", { class: "form", hidden: true, on: { submit } }, this.own.root, this.go);
    const laws = el("form", { class: "form", on: {
      submit: (/** @type {Event} */ event) => event.preventDefault() } });
    this.laws = new Form(laws, page.registry, page.store);
    this.title = el("h2", {});
    this.of = el("p", { class: "hint" });
    this.answer = el("div", {});
    this.root = el("div", { class: "view split analyse" },
      el("aside", { class: "side" }, el("section", { class: "card" }, this.presets.field),
        el("section", { class: "card choice" }, el("div", { class: "field" },
          el("label", { for: id }, t("analysis")), this.select), this.summary, this.more,
        this.fields, this.job.root),
        el("details", { class: "card laws" }, el("summary", {}, t("lawsOfAnalysis")), laws)),
      el("div", { class: "main" }, el("section", { class: "card" }, this.notice, this.title, this.of),
        this.answer));
    /** Counts what was asked of the server: an older answer is not shown. */
    this.turn = 0;
    /** @type {() => void} */
    this.unsubscribe = () => {};
  }

  /** The run that all views show: its scenario and options. */
  get request() {
    const { scenario, options } = this.page.store.state;
    return { scenario: scenario || (options.system ? null : FIRST), options };
  }

  /** The name of the analysis, empty if none is chosen. */
  get what() {
    const name = this.page.store.state.extra[WHAT] ?? "";
    return Object.hasOwn(this.analyses, name) ? name : "";
  }

  /** What Compute asks the server for. */
  get question() {
    return { ...this.request, analysis: this.what, settings: this.own.values };
  }

  show() {
    this.isOpening = true;
    this.unsubscribe = this.page.store.subscribe((_, changed) => {
      if (changed === "extra") return;
      clearTimeout(this.timer);
      this.timer = window.setTimeout(() => void this.look(), changed === "options" ? PAUSE : 0);
    });
    void this.look();
  }

  hide() {
    this.unsubscribe();
    clearTimeout(this.timer);
    this.job.stop();
  }

  /** Read what the server says about the system and drive, and show the fields. */
  async look() {
    const { registry } = this.page;
    this.turn += 1;
    const { turn } = this;
    try {
      if (!Object.keys(this.analyses).length) {
        this.analyses = await askJson("api/analyses");
        for (const each of Object.values(this.analyses)) translate(each);
        this.select.replaceChildren(el("option", { value: "" }, t("analysisNone")),
          ...Object.entries(this.analyses).map(([value, { title }]) => el("option", { value }, title)));
      }
      const about = await askJson("api/analyses/about", this.request);
      if (turn !== this.turn) return;
      for (const each of Object.values(about.parameters)) each.label = tr(each.label);
      this.about = about;
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (turn !== this.turn) return;
      if (error instanceof Offline) {
        this.notify(t("offline"));
        this.timer = window.setTimeout(() => void this.look(), RETRY);
        return;
      }
      const [text, field] = inPagesWords(registry, error instanceof Refusal && error.input || error);
      this.notify(text);
      this.laws.error(text, field);
      return;
    }
    const about = /** @type {import("./arguments.js").SystemAbout} */ (this.about);
    this.presets.show(this.request.scenario);
    this.laws.show(about.options);
    this.of.textContent = t("analysisOf", { title: tr(about.title) || t("presetNone"),
      system: tr(registry.systems[about.options.system].title),
      drive: tr(registry.drives[about.options.drive].title) });
    this.build();
  }

  /** @param {string} text of the line above the title; none hides it */
  notify(text) {
    this.notice.textContent = text;
    this.notice.hidden = text === "";
  }

  /** Show the analysis that the address names, or all that can be chosen. */
  build() {
    if (!this.about) return;
    const { extra } = this.page.store.state;
    const { what } = this;
    const analysis = /** @type {Analysis | undefined} */ (this.analyses[what]);
    leaveOut(this.page, Object.keys(extra).filter((name) => (name === WHAT ? !analysis
      : name.startsWith(KEY) && name !== ASK && !(analysis && Object.hasOwn(analysis.options, name.slice(KEY.length))))));
    this.notify("");
    this.select.value = what;
    this.root.dataset.form = what;
    const refused = this.about.refused[what];
    this.summary.hidden = this.more.hidden = !analysis;
    this.fields.hidden = !analysis || refused !== undefined;
    this.title.textContent = analysis?.title ?? t("analysisChoose");
    if (this.root.dataset.answered !== what) this.clear();
    if (!analysis) return;
    this.summary.textContent = analysis.summary;
    this.notes.textContent = analysis.notes;
    this.more.hidden = analysis.notes === "";
    this.own.build(what, analysis, this.about, Object.fromEntries(Object.keys(analysis.options)
      .filter((name) => KEY + name in extra).map((name) => [name, extra[KEY + name]])));
    this.age();
    const { isOpening } = this;
    this.isOpening = false;
    if (refused) {
      const { error, field, parts } = refused;
      this.refuse(new Refusal(error, field, parts));
      return;
    }
    if (isOpening && extra[ASK] === "1") void this.compute();
  }

  /** Take the result away; in its place stand all analyses, or where the picture will be if there can be one. */
  clear() {
    const { what } = this;
    this.job.stop();
    this.job.clear();
    this.asked = "";
    delete this.root.dataset.answered;
    this.answer.classList.remove("stale");
    const { scenario, options } = this.page.store.state;
    const row = (/** @type {[string, Analysis]} */ [name, { title, summary }]) => [
      el("dt", {}, openLink(this.page, { view: "analyse", scenario, options, extra: { [WHAT]: name } }, title)),
      el("dd", {}, summary)];
    this.answer.hidden = this.about?.refused[what] !== undefined;
    this.answer.replaceChildren(el("section", { class: "card" }, what
      ? el("div", { class: "picture waiting" }, el("p", { class: "soft" }, t("pictureHere")))
      : el("dl", { class: "analyses" }, ...Object.entries(this.analyses).flatMap(row))));
  }

  /** @param {Record<string, string>} changes of the fields */
  keep(changes) {
    const own = Object.entries(changes).map(([name, value]) => [KEY + name, value]);
    this.setExtra({ [WHAT]: this.what, ...Object.fromEntries(own) });
  }

  /** @param {Record<string, string>} own all that this view keeps in the address */
  setExtra(own) {
    const { extra } = this.page.store.state;
    const others = Object.entries(extra).filter(([name]) => !name.startsWith(KEY));
    this.page.store.set({ extra: { ...Object.fromEntries(others), ...own } }, "extra");
    // Which fields there are follows from the analysis and from what it varies.
    if (this.root.dataset.form !== this.what || !this.own.isWhole) this.build();
    else this.age();
  }

  /** Mark a result that is of something else than what the page says now. */
  age() {
    this.job.error.hidden = true;
    this.own.error(null);
    this.answer.classList.toggle("stale", this.asked !== "" && JSON.stringify(this.question) !== this.asked);
  }

  /** @param {Refusal} refusal why there is no result */
  refuse({ input, message, field: about }) {
    const [text, field] = input ? inPagesWords(this.own.registryInWords, input) : [tr(message), about];
    if (this.fields.hidden || !this.own.error(text, field)) this.job.refuse(inWords(text, this.own.words));
    else this.job.error.hidden = true;
  }

  /** @param {import("../page/block.js").Block} block a bifurcation curve */
  async showOverMap(block) {
    openOverMap(this.page, await fileOf(block, "csv", "text/csv").text());
  }

  /** @param {Record<string, string>} start options of the start from which the same is to be computed */
  begin(start) {
    this.laws.giveAll(start);
    void this.compute();
  }

  /** Ask the server, and show the result. */
  async compute() {
    const { question } = this;
    const { [ASK]: _, ...settings } = Object.fromEntries(Object.entries(this.page.store.state.extra)
      .filter(([name]) => name.startsWith(KEY)));
    // A second press while the same is computed asks for nothing else.
    if (this.job.isRunning && JSON.stringify(question) === this.asked) return;
    this.asked = JSON.stringify(question);
    this.setExtra({ ...settings, [ASK]: "1" });
    const block = await this.job.run("ws/analyse", question);
    if (JSON.stringify(question) !== this.asked) return;
    if (!block) {
      if (this.job.refusal) this.refuse(this.job.refusal);
      this.asked = "";
      return;
    }
    const answer = new ResultCard(block, this.analyses[question.analysis], this.own.words,
      (start) => this.begin(start));
    if (question.analysis === CURVE && block.about.points > 0) answer.actions.append(el("button", { type: "button", on: {
      click: () => void this.showOverMap(block) } }, t("showOverMap")));
    this.answer.replaceChildren(answer.root);
    // On a phone it comes below the form.
    if (this.answer.getBoundingClientRect().top > window.innerHeight) this.answer.scrollIntoView();
    this.age();
    this.root.dataset.answered = question.analysis;
    this.root.dataset.answers = String(Number(this.root.dataset.answers ?? 0) + 1);
  }
}

/**
 * Put what the program calls an analysis, its options and choices in the language of the page;
 * descriptions stay as they are.
 * @param {Analysis} analysis
 */
function translate(analysis) {
  for (const key of /** @type {const} */ (["title", "summary", "notes", "reading"])) analysis[key] = tr(analysis[key]);
  for (const field of Object.values(analysis.options)) {
    field.label = tr(field.label);
    field.description = tr(field.description);
    field.labels = Object.fromEntries(Object.entries(field.labels ?? {}).map(([key, text]) => [key, tr(text)]));
  }
}
