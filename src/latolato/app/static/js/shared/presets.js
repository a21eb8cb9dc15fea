/** The choice of a shipped scenario to begin with, and the question that it asks. */

import { t } from "../strings.js";
import { el, freshId } from "./dom.js";

/**
 * Return a field that chooses a scenario, the head of that field, the headline that goes with the
 * scenario, and what shows which one is on.
 * @param {import("./state.js").Page} page
 */
export function presetField(page) {
  const id = freshId();
  const runs = Object.entries(page.registry.scenarios)
    .filter(([, scenario]) => !(/** @type {any} */ (scenario).sweep));
  const select = el("select", { id, on: { change: () =>
    page.store.set({ scenario: select.value || null, options: {} }, "preset") } },
    el("option", { value: "" }, t("presetNone")),
    ...runs.map(([name, each]) => {
      const scenario = /** @type {any} */ (each);
      const { title, description, figure } = scenario;
      return el("option", { value: name, title: description },
        figure ? t("mapFigure", { title, figure }) : title);
    }));
  const about = el("p", { class: "hint" });
  const more = el("details", { class: "about" }, el("summary", {}, t("presetAbout")), about);
  const head = el("div", { class: "row preset-head" }, el("label", { for: id }, t("preset")));
  const field = el("div", { class: "field preset" }, head, select, more);
  const question = el("h2", { class: "headline" });
  const show = (/** @type {string | null} */ name) => {
    select.value = runs.some(([each]) => each === name) ? name ?? "" : "";
    const known = name && Object.hasOwn(page.registry.scenarios, name)
      ? page.registry.scenarios[name] : null;
    about.textContent = known?.description ?? "";
    more.hidden = !known;
    question.textContent = known?.question || t("questionOwn");
  };
  return { field, head, question, show };
}
