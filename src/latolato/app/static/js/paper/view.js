/** Paper: what the paper says, figure by figure, beside what an accurate calculation gives. */

import { askBlock, askJson, Offline, Refusal } from "../shared/api.js";
import { el, freshId } from "../shared/dom.js";
import { fileOf, JobLine, saveFile } from "../shared/jobs.js";
import { openLink, openState, textsOf } from "../shared/links.js";
import { ENGLISH, t } from "../strings.js";

/** @typedef {import("../shared/state.js").Page} Page */
/** @typedef {{name: string, label: string, title: string, caption: string,
 *   statements: {name: string, where: string, words: string}[], video: boolean, missing: string, stored?: boolean,
 *   scenarios: string[]}} Entry */
/** @typedef {{name: string, where: string, words: string, finding: string,
 *   criteria: [string, boolean][], assumption: string, verdict: string, says: string,
 *   shape: string, why: string}} Claim */

// A figure is made once it comes this near to the screen.
const MARGIN = "300px";
const VERDICTS = ["REPRODUCED", "ASSUMED", "NOT_AS_PRINTED", "METHOD_CHECK"];

export class PaperView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {Plate[]} */
    this.plates = [];
    /** @type {Plate[]} figures to be made, the next one first */
    this.queue = [];
    /** @type {Plate | null} */
    this.making = null;
    this.isShown = false;
    /** @type {Plate | null} what stays in place while figures above it appear */
    this.anchor = null;
    this.tally = el("ul", { class: "tally" });
    this.all = el("button", { type: "button", hidden: true, on: { click: () => this.makeAll() } },
      t("paperAll"));
    this.list = el("ol", {});
    this.main = el("div", { class: "main" });
    this.root = el("div", { class: "view paper split" },
      el("nav", { class: "side contents", "aria-label": t("paperList") }, this.list),
      el("div", { class: "main" },
        el("section", { class: "card" }, el("h1", {}, t("paperTitle")), el("p", {}, t("paperLead")),
          this.tally, this.all),
        this.main));
    this.near = new IntersectionObserver((entries) => {
      const near = entries.filter((e) => e.isIntersecting).map((e) => e.target);
      this.want(this.plates.filter((p) => near.includes(p.root) && !p.entry.video));
    }, { rootMargin: MARGIN });
    for (const event of ["wheel", "pointerdown", "keydown", "touchstart"])
      this.root.addEventListener(event, () => { this.anchor = null; }, { passive: true });
    this.loaded = this.load();
  }

  async load() {
    /** @type {Entry[]} */
    const entries = await askJson(this.page.registry.server ? "api/paper" : "paper/contents.json");
    this.plates = entries.map((entry) => new Plate(this, entry));
    this.list.replaceChildren(...this.plates.map((plate) => plate.item));
    this.main.replaceChildren(...this.plates.map((plate) => plate.root));
    this.count();
  }

  show() {
    this.isShown = true;
    void this.loaded.then(() => {
      if (!this.isShown) return;
      const kept = this.page.store.state.extra["paper.figure"];
      this.anchor = this.plates.find((p) => p.entry.name === kept) ?? null;
      this.anchor?.root.scrollIntoView();
      for (const plate of this.plates) this.near.observe(plate.root);
    });
  }

  hide() {
    this.isShown = false;
    this.near.disconnect();
    for (const plate of [...this.queue]) plate.job.stop();
    this.making?.job.stop();
  }

  /** Make every figure that needs no video. */
  makeAll() {
    this.want(this.plates.filter((plate) => !plate.entry.video));
  }

  /**
   * Make figures, before others that wait.
   * @param {Plate[]} plates
   */
  want(plates) {
    const open = plates.filter((plate) => !plate.isMade && plate !== this.making);
    this.queue = [...open, ...this.queue.filter((plate) => !open.includes(plate))];
    if (this.making) this.tellWaiting();
    else void this.work();
  }

  /**
   * Make a figure no more that waits.
   * @param {Plate} plate
   */
  drop(plate) {
    this.queue = this.queue.filter((other) => other !== plate);
  }

  /** Say at each figure that waits that it does. */
  tellWaiting() {
    if (this.making) for (const plate of this.queue) plate.wait(this.making);
  }

  /** Make what waits, one after the other. */
  async work() {
    for (;;) {
      const plate = this.queue.shift();
      if (!plate) return;
      this.making = plate;
      this.tellWaiting();
      try {
        await plate.make();
      } finally {
        this.making = null;
      }
      this.count();
      this.anchor?.root.scrollIntoView();
    }
  }

  /** Show how many claims met each verdict so far. */
  count() {
    const claims = this.plates.flatMap((plate) => plate.claims);
    const total = this.plates.reduce((sum, p) => sum + p.entry.statements.length, 0);
    this.tally.replaceChildren(
      ...VERDICTS.map((verdict) => {
        const number = claims.filter((c) => c.verdict === verdict).length;
        return el("li", { class: `verdict ${verdict}` },
          el("b", {}, String(number)), ` ${t(`shape_${verdict}`)} ${t(verdict)}`);
      }),
      el("li", { class: "soft" }, t("paperOpen", { count: total - claims.length, total })));
    this.all.hidden = this.plates.every((p) => p.entry.video || p.isMade);
    this.root.dataset.judged = String(claims.length);
  }
}

/** One figure with its claims. */
class Plate {
  /**
   * @param {PaperView} view
   * @param {Entry} entry
   */
  constructor(view, entry) {
    this.view = view;
    this.entry = entry;
    this.isMade = false;
    /** @type {Claim[]} */
    this.claims = [];
    const id = `paper-${entry.name}`;
    const name = entry.label === entry.title ? entry.title : `${entry.label}. ${entry.title}`;
    this.marks = el("span", { class: "marks" });
    this.item = el("li", { lang: ENGLISH }, el("a", { href: `#${id}`, on: {
      click: (/** @type {MouseEvent} */ event) => {
        event.preventDefault();
        const { store } = view.page;
        store.amend({ extra: { ...store.state.extra, "paper.figure": entry.name } });
        view.anchor = this;
        this.root.scrollIntoView();
        this.heading.focus({ preventScroll: true });
      } } }, el("b", {}, entry.label), ` ${entry.title}`), this.marks);
    this.heading = el("h2", { tabindex: "-1", lang: ENGLISH }, name);
    this.job = new JobLine();
    this.start = el("button", { type: "button", on: { click: () => this.view.want([this]) } },
      t("paperFilm"));
    this.picture = el("div", { class: "picture" });
    this.links = el("div", { class: "links" }, ...this.scenarioLinks());
    this.list = el("div", { class: "claims" }, ...entry.statements.map((s) => openClaim(s)));
    this.offer = entry.video ? this.videoOffer() : null;
    this.root = el("section", { class: `card plate ${entry.caption ? "" : "text"}`, id },
      this.heading,
      el("div", { class: "plate-body" },
        el("div", {}, this.picture, this.offer, this.job.root,
          entry.caption && el("p", { class: "hint", lang: ENGLISH }, entry.caption), this.links),
        this.list));
  }

  videoOffer() {
    const { missing } = this.entry;
    this.start.disabled = missing !== "";
    return el("div", {}, this.start,
      el("p", { class: "hint" }, missing || t("paperFilmHint")));
  }

  /** Return a link for each shipped scenario of the figure. */
  scenarioLinks() {
    const { registry } = this.view.page;
    return this.entry.scenarios.map((name) => {
      const scenario = registry.scenarios[name];
      const view = scenario.sweep ? "map" : "play";
      return openLink(this.view.page, { view, scenario: name, options: {} },
        t(scenario.sweep ? "openTitleInMap" : "openTitleInPlay", { title: scenario.title }),
        scenario.description);
    });
  }

  /**
   * Say that another figure is made first.
   * @param {Plate} making
   */
  wait({ entry }) {
    this.start.disabled = true;
    const leave = () => {
      this.view.drop(this);
      this.release();
      if (this.view.isShown) this.start.focus({ preventScroll: true });
    };
    // Figures that come by themselves are not read out.
    if (!this.offer) this.job.wait(t("paperTurn"), leave, "off");
    else this.job.wait(t("paperWaits", { name: entry.caption ? entry.label : entry.title }), leave);
  }

  /** Allow the video to be requested again. */
  release() {
    this.start.disabled = this.entry.missing !== "";
  }

  /** Return the figure, computed by the program or stored in the site; null without one. */
  async block() {
    const { name, stored } = this.entry;
    if (stored === undefined) return this.job.run("ws/paper", { figure: name });
    if (!stored) return null;
    this.job.clear();
    try {
      return await askBlock(`paper/${name}.block`);
    } catch (error) {
      if (!(error instanceof Offline || error instanceof Refusal)) throw error;
      this.job.refuse(t("paperUnread"));
      return null;
    }
  }

  /** Compute, draw and judge. */
  async make() {
    if (this.entry.caption) this.picture.classList.add("waiting");
    this.start.disabled = true;
    const block = await this.block();
    this.picture.classList.remove("waiting");
    if (!block) {
      this.release();
      return;
    }
    this.isMade = true;
    this.claims = block.about.claims;
    this.offer?.remove();
    if (block.arrays.svg) this.showPicture(fileOf(block, "svg", "image/svg+xml"));
    const { made, source } = block.about;
    this.list.replaceChildren(...this.claims.map(judgedClaim),
      el("p", { class: "hint" }, made && `${made} `,
        t(source === "report" ? "paperReport" : "paperQuick")));
    this.marks.textContent = this.claims.map((claim) => claim.shape).join("");
    this.marks.title = this.claims.map((claim) => claim.says).join(", ");
    this.showCases(block.about.cases);
  }

  /** @param {Blob} file */
  showPicture(file) {
    const { label, title, name } = this.entry;
    const address = URL.createObjectURL(file);
    this.picture.replaceChildren(el("img", { src: address, alt: `${label}: ${title}` }));
    const save = () => saveFile(file, `${name}.svg`);
    this.links.append(el("button", { type: "button", on: { click: save } }, t("file_svg")));
  }

  /** @param {{label: string, options: Record<string, any>}[]} cases */
  showCases(cases) {
    if (!cases.length) return;
    const { page } = this.view;
    const id = freshId();
    const select = el("select", { id }, ...cases.map(({ label }, i) =>
      el("option", { value: String(i) }, label)));
    const go = () => openState(page, { view: "play", scenario: null,
      options: textsOf(page.registry, cases[Number(select.value)].options) });
    this.links.after(el("div", { class: "row cases" },
      el("label", { for: id }, t("paperCases", { count: cases.length })), select,
      el("button", { type: "button", on: { click: go } }, t("openInPlay"))));
  }
}

/**
 * Return a statement that is not judged yet.
 * @param {{where: string, words: string}} statement
 */
function openClaim({ where, words }) {
  return el("article", { class: "claim" },
    el("p", { class: "place soft", lang: ENGLISH }, where),
    el("blockquote", { lang: ENGLISH }, el("q", {}, words)),
    el("p", { class: "hint" }, t("paperUnjudged")));
}

/**
 * Return a claim with its verdict and the numbers that decide it.
 * @param {Claim} claim
 */
function judgedClaim(claim) {
  return el("article", { class: `claim ${claim.verdict}` },
    el("p", { class: "place", lang: ENGLISH },
      el("span", { class: `verdict ${claim.verdict}` },
        el("span", { "aria-hidden": "true" }, `${claim.shape} `), claim.says),
      el("span", { class: "soft" }, claim.where)),
    el("blockquote", { lang: ENGLISH }, el("q", {}, claim.words)),
    el("p", { lang: ENGLISH }, claim.finding),
    el("ul", { class: "criteria", lang: ENGLISH }, ...claim.criteria.map(([text, held]) => el("li", {},
      el("span", { class: held ? "held" : "failed", role: "img",
        "aria-label": t(held ? "held" : "failed") },
        held ? "✓" : "✗"), ` ${text}`))),
    claim.assumption && el("p", {}, el("b", {}, t("paperAssumed")), " ",
      el("span", { lang: ENGLISH }, claim.assumption)),
    el("p", { class: "soft", lang: ENGLISH }, claim.why));
}
