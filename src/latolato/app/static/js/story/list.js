/** The list of stories and challenges, before one is chosen. */

import { InputError } from "../model/rules.js";
import { Offline } from "../page/api.js";
import { el } from "../page/dom.js";
import { inLanguage } from "../page/refusals.js";
import { actingLink } from "../page/links.js";
import { format } from "../page/state.js";
import { t, tr } from "../strings.js";
import { load, loadAll } from "./load.js";
import { shownBy } from "./look.js";

/** @typedef {import("./check.js").StoryTable} StoryTable */

export class StoryList {
  /** @param {import("../page/state.js").Page} page */
  constructor(page) {
    this.page = page;
    this.lists = el("div", {});
    this.error = el("p", { class: "error", role: "alert", hidden: true });
    this.root = el("div", {}, el("p", {}, t("storiesIntro")), this.lists, this.error);
  }

  /** List the stories of the site. */
  async show() {
    const entries = await loadAll(this.page.registry);
    const cards = (/** @type {boolean} */ areStories) => el("ul", { class: "story-cards" },
      ...entries.flatMap(({ name, tables }) => (tables && "steps" in tables === areStories
        ? [this.card(name, tables)] : [])));
    this.lists.replaceChildren(cards(true), el("h3", {}, t("challengesList")), cards(false),
      ...entries.flatMap(({ error }) => (error ? [el("p", { class: "error" }, error)] : [])));
  }

  /**
   * @param {string} name
   * @param {StoryTable} tables
   */
  card(name, { title, summary, steps, minutes }) {
    const state = { view: "toy", scenario: null, options: {}, extra: { "story.name": name } };
    return el("li", { class: "card" }, el("h4", {},
      actingLink(format(state), () => void this.open(name), {}, tr(title))), el("p", {}, tr(summary)),
    el("p", { class: "hint" }, t(steps ? "storiesSteps" : "storiesMinutes", { count: steps?.length ?? 0, minutes })));
  }

  /**
   * Begin a story; what is wrong with it is said here.
   * @param {string} name
   */
  async open(name) {
    const { registry, store } = this.page;
    this.error.hidden = true;
    try {
      const tables = await load(registry, name);
      const look = tables.look ?? tables.steps[0].look;
      store.set(shownBy(store.state, look, { "story.name": name }), "preset");
      window.scrollTo(0, 0);
    } catch (error) {
      if (!(error instanceof InputError || error instanceof Offline)) throw error;
      this.error.hidden = false;
      this.error.textContent = inLanguage(error);
    }
  }
}
