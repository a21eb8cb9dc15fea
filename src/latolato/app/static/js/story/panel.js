/** The panel of a story beside the view that it shows: it follows the address, and changes it. */

import { InputError } from "../model/rules.js";
import { el, notify } from "../page/dom.js";
import { openLink, openState } from "../page/links.js";
import { sayLeft } from "../page/link_parts.js";
import { Runner } from "../player/runner.js";
import { t, tr } from "../strings.js";
import { Challenge } from "./challenge.js";
import { loadSchema, loadTables } from "./contents.js";
import { StoryList } from "./list.js";
import { runOnShow, shownBy } from "./look.js";
import { withPeriod } from "./numbers.js";
import { NOT_YET, Step } from "./step.js";

/** @typedef {import("./contents.js").StoryTable} StoryTable */

// Where the address asks for the list.
const LIST = "story.list";
// Where it says that the reader has tried what a step asks for, or goes on without.
const TRIED = "story.tried";
// As in story.css: there the panel lies at the bottom.
const NARROW = "(max-width: 800px) and (min-height: 561px)";
// A view that has just come has found its size by then.
const LAID_OUT = 500; // ms

export class StoryPanel {
  /**
   * @param {import("../page/state.js").Page} page
   * @param {string} changed in the address: a story that was chosen takes the focus
   */
  constructor(page, changed) {
    this.page = page;
    this.runner = new Runner(page.registry);
    /** @type {import("./contents.js").Schema} */
    this.schema = /** @type {any} */ (null);
    /** The story on show. @type {StoryTable | null} */
    this.tables = null;
    this.name = "";
    /** @type {Step | Challenge | null} */
    this.part = null;
    this.partAt = 0;
    /** @type {Step | Challenge | null} the part that was last brought into view */
    this.seen = null;
    this.counted = "";
    this.takesFocus = false;
    this.body = el("div", { class: "story-body" });
    this.title = el("h2", { tabindex: "-1" });
    this.all = new StoryList(page);
    const fold = el("button", { type: "button", class: "plain story-fold", "aria-expanded": "true", on: { click: () => {
      const isOpen = !this.root.classList.toggle("folded");
      fold.setAttribute("aria-expanded", String(isOpen));
    } } }, t("storyFold"));
    const leave = el("button", { type: "button", class: "plain", "aria-label": t("storyLeave"), title: t("storyLeave"),
      on: { click: () => this.leave() } }, "×");
    this.place = el("p", { class: "story-place" });
    this.progress = el("progress", { "aria-hidden": "true" });
    this.nav = el("div", { class: "actions" });
    this.root = el("aside", { class: "story", id: "story", "aria-label": t("story") },
      el("div", { class: "story-top" }, this.place, fold, leave), this.progress, this.title, this.body, this.nav);
    document.getElementById("main")?.before(this.root);
    page.store.subscribe((_, now) => void this.follow(now));
    void this.follow(changed);
  }

  /** What the address keeps of the story. */
  get kept() {
    const { extra } = this.page.store.state;
    const count = this.tables?.steps?.length ?? 1;
    const step = Number(extra["story.step"] ?? 1);
    return { name: extra["story.name"], answers: extra["story.answers"] ?? "",
      step: Number.isInteger(step) ? Math.min(Math.max(step, 1), count) : 1,
      hasTried: TRIED in extra };
  }

  /**
   * Show what the address names.
   * @param {string} changed
   */
  async follow(changed) {
    const { state } = this.page.store;
    const { name } = this.kept;
    const isList = name === undefined && LIST in state.extra;
    const isOpen = name !== undefined || isList;
    document.documentElement.toggleAttribute("data-story", isOpen);
    this.root.hidden = !isOpen;
    if (isList) this.showList(changed);
    if (name === undefined) {
      this.name = "";
      return;
    }
    if (name !== this.name) {
      this.name = name;
      this.tables = this.part = null;
      this.takesFocus = changed === "preset";
      await this.open(name);
    }
    if (!this.tables || name !== this.name) return;
    this.show();
    await this.count();
  }

  /**
   * Show the list of stories.
   * @param {string} changed in the address
   */
  showList(changed) {
    if (this.body.firstChild === this.all.root) return;
    this.tables = this.part = null;
    this.progress.hidden = true;
    this.place.textContent = "";
    this.title.textContent = t("stories");
    this.body.replaceChildren(this.all.root);
    this.nav.replaceChildren();
    void this.all.show();
    if (changed !== "address") this.title.focus();
  }

  /** @param {string} name */
  async open(name) {
    const [schema, all] = await Promise.all([loadSchema(), loadTables()]);
    if (name !== this.name) return;
    if (!Object.hasOwn(all, name)) {
      this.refuse(t("storyUnknown", { name }));
      return;
    }
    this.schema = schema;
    this.tables = all[name];
    // An address that names a story alone shows what the story shows.
    const { scenario, options, extra } = this.page.store.state;
    const step = extra["story.step"];
    const isStrange = step !== undefined && String(this.kept.step) !== step;
    if (isStrange) this.page.store.drop(["story.step"]);
    if (!scenario && !Object.keys(options).length) this.lookAgain();
    if (isStrange) sayLeft(this.page, [["story.step", step]], "link of story");
  }

  /**
   * Say on the stage why there is no story, and lead on; the address keeps nothing of it.
   * @param {string} text
   */
  refuse(text) {
    const { messages, store } = this.page;
    store.drop(Object.keys(store.state.extra).filter(isOfStory));
    messages.show("story", text, { isBad: true,
      actions: [{ label: t("storyAll"), act: () => openState(this.page, this.list) }] });
  }

  /** The state that shows the list of stories. */
  get list() {
    const { state } = this.page.store;
    return { ...state, extra: { ...withoutStory(state.extra), [LIST]: "1" } };
  }

  listLink() {
    return openLink(this.page, this.list, t("storyAll"));
  }

  /** Show the step or the challenge, as far as the reader is. */
  show() {
    const { step, answers, hasTried } = this.kept;
    const tables = /** @type {StoryTable} */ (this.tables);
    if (!this.part || this.partAt !== step) {
      this.partAt = step;
      this.counted = "";
      this.title.textContent = tr(tables.title);
      this.part = tables.task ? new Challenge(this, tables)
        : new Step(this, tables.steps[step - 1], { answer: (choice) => this.answer(choice),
          goOn: () => this.page.store.keep(TRIED, "1"), did: () => this.did() });
      this.body.replaceChildren(this.part.root);
      this.body.scrollTop = this.root.scrollTop = 0;
      this.makeNav(step);
      if (this.takesFocus) this.part.head.focus();
      this.takesFocus = false;
    }
    if (this.part instanceof Step) this.part.show(answers[step - 1] ?? NOT_YET, hasTried);
  }

  /** @param {number} step */
  makeNav(step) {
    const { steps, title } = /** @type {StoryTable} */ (this.tables);
    const again = el("button", { type: "button", on: { click: () => this.lookAgain() } }, t("storyLook"));
    this.progress.hidden = !steps;
    this.place.textContent = steps ? t("storyStep", { step, count: steps.length }) : "";
    if (!steps) {
      this.nav.replaceChildren(again, this.listLink());
      return;
    }
    [this.progress.max, this.progress.value] = [steps.length, step];
    const isLast = step === steps.length;
    const next = () => {
      if (!isLast) this.go(step + 1);
      else {
        notify(t("storyFinished", { title: tr(title) }));
        openState(this.page, this.list);
      }
    };
    this.nav.replaceChildren(
      el("button", { type: "button", disabled: step === 1, on: { click: () => this.go(step - 1) } }, t("storyBack")),
      again,
      el("button", { type: "button", class: "play", on: { click: next } }, t(isLast ? "storyFinish" : "storyNext")));
  }

  /** Compute the run on show, and let the step or the challenge look at it. */
  async count() {
    const { registry, store } = this.page;
    const { part } = this;
    const { extra } = store.state;
    const request = part instanceof Challenge ? part.request() : runOnShow(registry, store.state);
    const text = JSON.stringify(request);
    if (text !== this.counted) {
      this.counted = text;
      this.block = undefined;
      /** @type {import("../page/block.js").Block | null | undefined} */
      const block = request && await this.runner.compute(request).catch((error) => {
        if (error instanceof DOMException && error.name === "AbortError") return undefined;
        // The view says what is wrong.
        if (error instanceof InputError) return null;
        throw error;
      });
      const whole = block && part instanceof Step && part.needsPeriod
        ? await withPeriod(registry, /** @type {any} */ (request), block) : block;
      if (text !== this.counted || part !== this.part) return;
      this.block = whole;
    }
    if (this.block === undefined) return;
    part?.update(this.block, store.state.extra);
    if (this.seen !== part && matchMedia(NARROW).matches) setTimeout(bringUp, LAID_OUT);
    this.seen = part;
  }

  /** @param {number} choice from 1 on */
  answer(choice) {
    const { answers, step } = this.kept;
    const all = answers.padEnd(step, NOT_YET);
    this.page.store.keep("story.answers", all.slice(0, step - 1) + choice + all.slice(step));
  }

  /** Keep from the run on show onwards that the reader has tried: Back goes to where nobody had. */
  did() {
    const { store } = this.page;
    store.amend({ extra: { ...store.state.extra, [TRIED]: "1" } });
  }

  /** Show the step as it begins. */
  lookAgain() {
    this.go(this.kept.step);
  }

  /** @param {number} step */
  go(step) {
    const { store } = this.page;
    const { answers, name } = this.kept;
    const tables = /** @type {StoryTable} */ (this.tables);
    const look = tables.look ?? tables.steps[step - 1].look;
    if (this.part && step !== this.partAt) this.takesFocus = true;
    store.set(shownBy(store.state, look, { "story.name": name,
      ...(tables.steps && { "story.step": String(step) }), ...(answers && { "story.answers": answers }) }), "preset");
  }

  /** End the story. */
  leave() {
    const { store } = this.page;
    store.set({ extra: withoutStory(store.state.extra) }, "view");
  }
}

/** Bring what a step speaks of to the top, above a panel at the bottom. */
function bringUp() {
  document.querySelector("main canvas")?.scrollIntoView({ block: "start" });
}

/** @param {Record<string, string>} extra */
function withoutStory(extra) {
  return Object.fromEntries(Object.entries(extra).filter(([name]) => !isOfStory(name)));
}

/** @param {string} name */
function isOfStory(name) {
  return name.startsWith("story.");
}
