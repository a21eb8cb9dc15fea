/** The page: its views, its colours and what they share. */

import { loadRegistry } from "./model/registry.js";
import { beforePrint, el, isUsable } from "./page/dom.js";
import { keep, recall } from "./page/preferences.js";
import { speakInPage } from "./page/language.js";
import { actingLink } from "./page/links.js";
import { Messages, sayOffline } from "./page/messages.js";
import { learnKinds, learnLabels } from "./page/refusals.js";
import { Store, format, isReadable, parse } from "./page/state.js";
import { ENGLISH, languageCode, t } from "./strings.js";

/** @typedef {import("./page/state.js").Page} Page */

// Every view is a module that is loaded when it is first wanted, and the class that it exports.
/** @type {Record<string, () => Promise<new (page: Page) => {root: HTMLElement, show(): void,
 *   hide(): void}>>} */
const VIEWS = {
  toy: async () => (await import("./toy/view.js")).ToyView,
  map: async () => (await import("./map/view.js")).MapView,
  measure: async () => (await import("./measure/view.js")).MeasureView,
  analyse: async () => (await import("./analyse/view.js")).AnalyseView,
  report: async () => MissingReport,
};
// Views that need Python beside the page.
const NEED_PROGRAM = /** @type {Record<string, string>} */ ({ measure: "app,video", analyse: "app" });
// The report is a page of its own beside this one.
const REPORT = "report/index.html";
const THEMES = ["auto", "light", "dark"];
const THEME = "latolato.theme";
// Where the toy opens in place of a page that `offline.js` has not stored.
const NOT_STORED = "#not-stored";
// A view that the server did not give is asked for again after this time.
const RETRY = 1000; // ms
const FOCUSABLE = "a[href], button, input, select, textarea, summary, [tabindex='0']";
// How often the focus is checked.
const SOON = 100; // ms

/** Show the theme that was chosen and tell those that draw. */
function applyTheme(/** @type {string} */ theme) {
  document.documentElement.dataset.theme = theme;
  const button = document.getElementById("theme");
  const name = t(theme === "light" ? "themeLight" : theme === "dark" ? "themeDark" : "themeAuto");
  if (button) {
    button.textContent = name;
    button.setAttribute("aria-label", t("themeLabel", { name }));
  }
  window.dispatchEvent(new Event("themechange"));
}

function startTheme() {
  let theme = document.documentElement.dataset.theme ?? "auto";
  applyTheme(theme);
  document.getElementById("theme")?.addEventListener("click", () => {
    theme = THEMES[(THEMES.indexOf(theme) + 1) % THEMES.length];
    keep(THEME, theme);
    applyTheme(theme);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => applyTheme(theme));
  // Paper is light, and says where it comes from.
  beforePrint(() => {
    applyTheme("light");
    for (const line of document.querySelectorAll(".address")) line.textContent = location.href;
  });
  window.addEventListener("afterprint", () => applyTheme(theme));
}

/** @param {Page} page */
function startViews(page) {
  const main = /** @type {HTMLElement} */ (document.getElementById("main"));
  const nav = /** @type {HTMLElement} */ (document.getElementById("views"));
  nav.setAttribute("aria-label", t("views"));
  learnLabels(page.registry.options);
  // Of a pair, each ball is a parameter as well.
  learnLabels({ right: { label: t("right") }, left: { label: t("left") } });
  learnKinds(page.registry);
  /** @type {Record<string, any>} */
  const made = {};
  /** @type {string | null} */
  let current = null;
  let again = 0;
  /** Made when somebody first shares. @type {import("./page/share.js").Share | null} */
  let share = null;
  const shareButton = el("button", { type: "button", "aria-expanded": "false", on: { click: async () => {
    const module = await import("./page/share.js").catch(sayOffline);
    if (!module) return;
    share ??= new module.Share(shareButton, page.store, () => (current ? made[current] : {}));
    await share.share();
  } } }, t("share"));
  const sharing = el("div", { class: "share" }, shareButton);
  // Of views without a stage or a toolbar of their own.
  const ownLine = el("div", { class: "stage-tools" });
  const links = Object.keys(VIEWS).map((name) => {
    if (name === "report" && page.registry.report)
      return { name, link: el("a", { href: reportAddress() }, t("view_report")) };
    const isForProgram = !page.registry.server && name in NEED_PROGRAM;
    const link = actingLink(`?view=${name}`, () => page.store.set({ view: name }, "view"),
      { class: isForProgram && "program", title: isForProgram && t("tabProgram") }, t(`view_${name}`));
    return { name, link };
  });
  nav.replaceChildren(...links.map(({ link }) => link));

  const show = async () => {
    const { view } = page.store.state;
    for (const { name, link } of links) {
      if (link.getAttribute("href")?.startsWith(REPORT)) continue;
      link.href = format({ ...page.store.state, view: name });
      if (name === view) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    if (view === current) return;
    if (current) {
      made[current].hide();
      page.messages.clear();
    }
    current = null;
    if (!made[view] && !page.registry.server && view in NEED_PROGRAM) {
      made[view] = programView(page, view);
    } else if (!made[view]) {
      const View = await VIEWS[view]().catch((error) => {
        if (error instanceof TypeError) return null; // not fetched
        throw error;
      });
      if (page.store.state.view !== view) return;
      if (!View) {
        sayOffline();
        clearTimeout(again);
        again = window.setTimeout(() => void show(), RETRY);
        return;
      }
      made[view] ??= new View(page);
      /** @type {any} */ (window).latolato = { views: made };
    }
    if (current === view) return;
    current = view;
    const title = t(`view_${view}`);
    // A view that shows no title of its own has one for those who hear the page.
    const head = made[view].root.querySelector("h1") ? [] : [el("h1", { class: "unseen" }, title)];
    const { root } = made[view];
    main.replaceChildren(...head, root);
    const top = root.querySelector(".main") ?? root;
    (root.querySelector(".stage-messages") ?? top).prepend(page.messages.root);
    if (!root.querySelector(".stage-tools")) page.messages.root.after(ownLine);
    root.querySelector(".stage-tools").append(sharing);
    made[view].show();
    share?.open(false);
    document.title = `${title} · latolato`;
  };
  page.store.subscribe(() => void show());
  void show();
}

/** What stands in place of a view that is not here: what it does, and how to get it. */
class MissingView {
  /**
   * @param {string} view
   * @param {string} text
   * @param {string[]} lines to type
   * @param {(Node | string)[]} more
   */
  constructor(view, text, lines, ...more) {
    this.root = el("div", { class: "view" }, el("section", { class: "card" }, el("h1", {}, t(`view_${view}`)),
      el("p", {}, text), el("div", { class: "code" }, el("pre", {}, el("code", {}, lines.join("\n")))), el("p", {}, ...more)));
  }

  show() {}

  hide() {}
}

/**
 * Return what stands in place of a view of the installed program, where there is only the page.
 * @param {Page} page
 * @param {string} view
 */
function programView({ registry }, view) {
  const docs = registry.docs ? el("a", { href: "docs/index.html" }, t("documentation")) : "";
  return new MissingView(view, `${t(`program_${view}`)} ${t("programHow")}`,
    [`pip install ".[${NEED_PROGRAM[view]}]"`, "latolato app"], docs);
}

/** What stands in place of a report that nobody has made. */
class MissingReport extends MissingView {
  /** @param {Page} page */
  constructor({ registry }) {
    const [folder, lines] = registry.server ? ["latolato-report", ["latolato reproduce --quick", "latolato app"]]
      : ["FOLDER/report", ["latolato site FOLDER"]];
    super("report", t("reportMissing", { name: folder }), lines, registry.server ? t("reportFiner") : "");
  }
}

/**
 * Return the address of a part of the report in the language of the page: anchors for other languages than English
 * begin with their codes.
 * @param {string} [part]
 */
function reportAddress(part = "") {
  const anchor = languageCode() === ENGLISH ? part : `${languageCode()}-${part || "top"}`;
  return anchor ? `${REPORT}#${encodeURIComponent(anchor)}` : REPORT;
}

/**
 * Tell a story beside the views as soon as an address names one, or list them all.
 * @param {Page} page
 */
function startStories(page) {
  const begin = (/** @type {string} */ changed) => {
    if (!["story.name", "story.list"].some((name) => name in page.store.state.extra)) return;
    end();
    void import("./story/panel.js").then(({ StoryPanel }) => new StoryPanel(page, changed));
  };
  const end = page.store.subscribe((_, changed) => begin(changed));
  begin("address");
}

/**
 * Keep a place for the keyboard: where the element that has the focus goes or is disabled, the next one
 * in the smallest part of the page that is left takes it, else the last one; of an element that is gone, the first.
 */
function keepFocus() {
  /** What had the focus, and all that it was in. @type {Element[]} */
  let chain = [];
  document.addEventListener("focusin", ({ target }) => {
    chain = [];
    for (let at = /** @type {Element | null} */ (target); at; at = at.parentElement) chain.push(at);
  });
  // Who points beside all controls wants none; one that is pointed at takes the focus after this.
  document.addEventListener("pointerdown", () => { chain = []; }, true);
  setInterval(() => {
    const [held, ...around] = chain;
    // Some browsers leave the focus on what was disabled.
    if (!held || ![held, document.body].includes(document.activeElement ?? held) || isUsable(held)) return;
    for (const part of around.filter(isUsable)) {
      const all = [...part.querySelectorAll(FOCUSABLE)].filter(isUsable);
      const next = all.find((each) =>
        held.compareDocumentPosition(each) === Node.DOCUMENT_POSITION_FOLLOWING);
      const nearest = /** @type {HTMLElement | undefined} */ (held.isConnected ? next ?? all.at(-1) : all[0]);
      if (!nearest) continue;
      nearest.focus({ preventScroll: true });
      return;
    }
  }, SOON);
}

/** Keep the site in the browser, so that it opens without a network. */
async function keepOffline() {
  // A site in a frame leaves that to the page around it; pages of the program change with it.
  if (window.top !== window || !("serviceWorker" in navigator)) return;
  const { variant } = await import("./kernels/load.js");
  await navigator.serviceWorker.register(`offline.js?variant=${variant()}`);
}

document.documentElement.dataset.theme = recall(THEME) ?? "auto";
// What checks the parts of a link comes with the registry, where there are any.
const linkParts = location.search ? import("./page/link_parts.js") : null;
const store = new Store(window);
// An address of the view that the report has replaced: it named a figure.
const figure = store.state.extra["paper.figure"] ?? "";
if (store.state.view === "paper") store.amend({ view: "report", extra: {} }, "preset");
// The first view's modules come while the server makes the registry; a site has none of those that need Python.
if (Object.hasOwn(VIEWS, store.state.view) && !(store.state.view in NEED_PROGRAM)) VIEWS[store.state.view]().catch(() => {});
const registry = await loadRegistry();
/** @type {Page} */
const page = { registry, store, messages: new Messages() };
await speakInPage(page);
if (store.state.view === "report" && registry.report) {
  location.replace(reportAddress(figure));
  await new Promise(() => {}); // the browser leaves this page
}
if (linkParts && isReadable(location.search, registry.format)) {
  const { readable, sayLeft } = await linkParts;
  const { state, left } = readable(registry, store.state, Object.keys(VIEWS));
  // A view of an older version goes by its new name from now on.
  const asked = new URLSearchParams(location.search).get("view") ?? state.view;
  if (format(state) !== format(store.state) || asked !== state.view) store.amend(state, "preset");
  sayLeft(page, left);
} else if (linkParts) {
  page.messages.show("link", t("newerAddress"), { stays: true });
  store.amend(parse(""), "preset");
}
if (location.hash === NOT_STORED) {
  page.messages.show("link", t("pageNotStored"), { stays: true });
  store.amend({}); // without that mark in the address
}
/** @type {HTMLElement} */ (document.querySelector(".skip")).textContent = t("skip");
startTheme();
keepFocus();
startViews(page);
startStories(page);
if (!registry.server) keepOffline().catch(() => {});
