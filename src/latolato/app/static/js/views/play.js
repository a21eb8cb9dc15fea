/** Play: parameters on one side, the motion that they make on the other. */

import { askBlock, newest } from "../api.js";
import { el, tell } from "../dom.js";
import { Downloads } from "../downloads.js";
import { Form, withLaws } from "../form.js";
import { Motion } from "../motion.js";
import { Player } from "../player.js";
import { t } from "../strings.js";

/** @typedef {import("../main.js").Page} Page */

/** What is on show where the address says nothing. */
export const FIRST = "fig04b_push";

export class PlayView {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    const form = el("form", { class: "form", on: {
      submit: (/** @type {Event} */ e) => e.preventDefault() } });
    this.presets = this.makePresets();
    const stage = el("div", { class: "player" });
    this.notes = el("p", { class: "notes", role: "status" });
    this.code = el("div", {});
    this.downloads = new Downloads();
    this.root = el("div", { class: "view split" },
      el("aside", { class: "side" }, this.presets.field, this.makeActions(),
        this.downloads.root, form),
      el("div", { class: "main" }, this.notes, stage, el("details", { class: "card" },
        el("summary", {}, t("code")), el("p", { class: "hint" }, t("codeHint")), this.code)));
    this.form = new Form(form, page.registry, page.store);
    this.player = new Player(stage);
    this.run = newest(() => this.simulate());
    /** @type {() => void} */
    this.unsubscribe = () => {};
  }

  makePresets() {
    const groups = Object.entries(this.page.registry.scenarios)
      .filter(([, s]) => !(/** @type {any} */ (s).sweep));
    const select = el("select", { id: "preset", on: { change: () =>
      this.page.store.set({ scenario: select.value || null, options: {} }, "preset") } },
      el("option", { value: "" }, t("presetNone")),
      ...groups.map(([name, s]) => {
        const scenario = /** @type {any} */ (s);
        const figure = scenario.figure ? ` (Fig. ${scenario.figure})` : "";
        return el("option", { value: name, title: scenario.description }, `${scenario.title}${figure}`);
      }));
    const about = el("p", { class: "hint" });
    const field = el("div", { class: "field preset" }, el("label", { for: "preset" }, t("preset")), select, about);
    return { field, select, about };
  }

  makeActions() {
    this.pin = el("button", { type: "button", on: { click: () => {
      const pinned = this.player.togglePin();
      if (this.pin) this.pin.textContent = t(pinned ? "unpin" : "pin");
    } } }, t("pin"));
    const share = el("button", { type: "button", on: { click: async () => {
      await navigator.clipboard.writeText(location.href);
      tell(t("copied"));
    } } }, t("share"));
    return el("div", { class: "actions" }, this.pin, share);
  }

  show() {
    this.unsubscribe = this.page.store.subscribe((_, changed) => {
      if (changed !== "extra") this.run(null);
    });
    this.run(null);
  }

  hide() {
    this.unsubscribe();
    this.downloads.stop();
    this.player.clock.pause();
  }

  /** Simulate what the address asks for, and show it. */
  async simulate() {
    const { registry, store } = this.page;
    let { scenario, options } = store.state;
    if (!scenario && !options.system) scenario = FIRST;
    if (scenario && options.system) {
      // A scenario's own values do not fit another system.
      options = withLaws(registry, options, {}, options.system, options.drive ?? "static");
    }
    this.presets.select.value = scenario ?? "";
    this.presets.about.textContent = scenario ? registry.scenarios[scenario]?.description ?? "" : "";
    this.form.build();
    try {
      const block = await askBlock("/api/run", { scenario, options });
      const motion = new Motion(block);
      this.form.show(block.about.options);
      this.player.show(motion);
      this.notes.textContent = block.about.warnings.map((/** @type {string} */ text) =>
        t("warning", { text })).join(" ");
      this.showCode(block.about);
      this.downloads.show({ scenario, options }, block.about.balls.length > 1);
      this.root.dataset.runs = String(Number(this.root.dataset.runs ?? 0) + 1);
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      this.form.error(error.message, /** @type {any} */ (error).field ?? null);
    }
  }

  /** @param {any} about */
  showCode(about) {
    this.code.replaceChildren(...[about.python, about.command].map((text) => el("div", { class: "code" },
      el("pre", { tabindex: "0" }, text),
      el("button", { type: "button", class: "plain", on: { click: async () => {
        await navigator.clipboard.writeText(text);
        tell(t("copied"));
      } } }, t("copy")))));
  }
}
