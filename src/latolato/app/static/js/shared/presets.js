/** The choice of a shipped scenario to begin with. */

import { t } from "../strings.js";
import { el, freshId } from "./dom.js";

/**
 * Return a field that chooses a scenario, and what shows which one is on.
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
  const field = el("div", { class: "field preset" },
    el("label", { for: id }, t("preset")), select, about);
  const show = (/** @type {string | null} */ name) => {
    select.value = runs.some(([each]) => each === name) ? name ?? "" : "";
    about.textContent = name && Object.hasOwn(page.registry.scenarios, name)
      ? page.registry.scenarios[name].description : "";
  };
  return { field, show };
}
