/** The questions that can be asked, in groups; one is chosen. */

import { el } from "../shared/dom.js";
import { t, tr } from "../strings.js";

/** @typedef {{title: string, group: string, term: string, reading: string, first: string[],
 *   summary: string, notes: string, run: string[],
 *   options: Record<string, import("./form.js").Field>}} Asking */

// Beside the picture there is room for the whole list; above it there is not.
const NARROW = "(max-width: 800px)";

/**
 * Put what the program calls questions, their options and choices in the language of the page;
 * descriptions stay as they are.
 * @param {Record<string, Asking>} forms
 */
export function translateQuestions(forms) {
  for (const form of Object.values(forms)) {
    for (const key of /** @type {const} */ (["title", "group", "term", "reading"])) form[key] = tr(form[key]);
    for (const field of Object.values(form.options)) {
      field.label = tr(field.label);
      field.choices = Object.fromEntries(Object.entries(field.choices).map(([key, text]) => [key, tr(text)]));
    }
  }
}

export class QuestionList {
  /** @param {(name: string) => void} chosen */
  constructor(chosen) {
    this.chosen = chosen;
    /** @type {Record<string, HTMLButtonElement>} */
    this.buttons = {};
    this.body = el("nav", { "aria-label": t("questions") });
    this.root = el("details", { class: "card questions", open: !matchMedia(NARROW).matches },
      el("summary", {}, t("questions")), this.body);
  }

  /**
   * Show the questions of all groups.
   * @param {Record<string, Asking>} forms
   */
  build(forms) {
    const groups = [...new Set(Object.values(forms).map(({ group }) => group))];
    this.body.replaceChildren(...groups.map((group) => el("section", {}, el("h3", {}, group),
      el("ul", {}, ...Object.entries(forms).filter(([, form]) => form.group === group)
        .map(([name, form]) => el("li", {}, this.button(name, form)))))));
  }

  /**
   * @param {string} name
   * @param {Asking} form
   */
  button(name, form) {
    const button = el("button", { type: "button", on: { click: () => {
      if (matchMedia(NARROW).matches) this.root.open = false;
      this.chosen(name);
    } } }, el("span", {}, form.title), el("small", {}, form.term));
    this.buttons[name] = button;
    return button;
  }

  /**
   * Mark the question that is on, and those that cannot be asked now.
   * @param {string} name
   * @param {Record<string, string>} unfit why they cannot
   */
  show(name, unfit) {
    for (const [each, button] of Object.entries(this.buttons)) {
      if (each === name) button.setAttribute("aria-current", "true");
      else button.removeAttribute("aria-current");
      button.classList.toggle("unfit", each in unfit);
      button.title = unfit[each] ?? "";
    }
  }
}
