/** The choice of a shipped scenario to begin with, and the question that it asks. */

import { t } from "../strings.js";
import { el, freshId } from "./dom.js";
import { FIRST } from "./state.js";

// The first one has the toy that the page opens with.
const GROUPS = ["presetsToy", "presetsPendulum", "presetsPaper"];

/**
 * Return a field that chooses a scenario, the head of that field, the headline that goes with the
 * scenario with a line below it for what a view tells, and what shows which one is on, with another
 * headline if there is one.
 * @param {import("./state.js").Page} page
 */
export function presetField(page) {
  const id = freshId();
  const runs = Object.entries(/** @type {import("../model/registry.js").Registry} */ (page.registry).scenarios)
    .filter(([, { sweep }]) => !sweep);
  const select = el("select", { id, on: { change: () =>
    page.store.set({ scenario: select.value || null, options: {} }, "preset") } },
    el("option", { value: "" }, t("presetNone")),
    ...GROUPS.map((group) => el("optgroup", { label: t(group) },
      ...runs.filter(([, scenario]) => groupOf(page.registry, scenario) === group)
        .sort(([one], [other]) => Number(other === FIRST) - Number(one === FIRST))
        .map(([name, { title, description, figure }]) => el("option", { value: name, title: description },
          figure ? t("mapFigure", { title, figure }) : title)))));
  const about = el("p", { class: "hint" });
  const more = el("details", { class: "about" }, el("summary", {}, t("presetAbout")), about);
  const head = el("div", { class: "row preset-head" }, el("label", { for: id }, t("preset")));
  const field = el("div", { class: "field preset" }, head, select, more);
  const question = el("h2", {});
  const told = el("p", {});
  const headline = el("div", { class: "headline" }, question, told);
  const show = (/** @type {string | null} */ name, asked = "") => {
    select.value = runs.some(([each]) => each === name) ? name ?? "" : "";
    const known = name && Object.hasOwn(page.registry.scenarios, name)
      ? page.registry.scenarios[name] : null;
    about.textContent = known?.description ?? "";
    more.hidden = !known;
    question.textContent = asked || known?.question || t("questionOwn");
  };
  return { field, head, headline, told, show };
}

/**
 * Return the name of the group of presets in which a scenario stands.
 * @param {import("../model/registry.js").Registry} registry
 * @param {import("../model/registry.js").Preset} scenario
 */
function groupOf({ systems }, { figure, options: { system } }) {
  if (figure) return "presetsPaper";
  return systems[system].contacts ? "presetsToy" : "presetsPendulum";
}
