/** The list of stories and challenges, before one is chosen. */

import { el } from "../page/dom.js";
import { actingLink } from "../page/links.js";
import { format } from "../page/state.js";
import { t, tr } from "../strings.js";
import { loadTables } from "./contents.js";
import { shownBy } from "./look.js";

/** @typedef {import("./contents.js").StoryTable} StoryTable */

export class StoryList {
  /** @param {import("../page/state.js").Page} page */
  constructor(page) {
    this.page = page;
    this.lists = el("div", {});
    this.root = el("div", {}, el("p", {}, t("storiesIntro")), this.lists);
  }

  /** List the stories of the site. */
  async show() {
    const entries = Object.entries(await loadTables());
    const cards = (/** @type {boolean} */ areStories) => el("ul", { class: "story-cards" },
      ...entries.filter(([, tables]) => "steps" in tables === areStories)
        .map(([name, tables]) => this.card(name, tables)));
    this.lists.replaceChildren(cards(true), el("h3", {}, t("challengesList")), cards(false));
  }

  /**
   * @param {string} name
   * @param {StoryTable} tables
   */
  card(name, { title, summary, steps, minutes, look = steps[0].look }) {
    const { store } = this.page;
    const story = { "story.name": name };
    const begin = () => {
      store.set(shownBy(store.state, look, story), "preset");
      window.scrollTo(0, 0);
    };
    return el("li", { class: "card" }, el("h4", {},
      actingLink(format({ view: "toy", scenario: null, options: {}, extra: story }), begin, {}, tr(title))),
    el("p", {}, tr(summary)),
    el("p", { class: "hint" }, t(steps ? "storiesSteps" : "storiesMinutes", { count: steps?.length ?? 0, minutes })));
  }
}
