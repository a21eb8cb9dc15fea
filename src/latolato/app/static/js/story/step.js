/** One step of a story: look, predict, try, explanation, one number. */

import { toSi } from "../model/units.js";
import { el, freshId } from "../page/dom.js";
import { local, t, tr } from "../strings.js";
import { parameterOf } from "./look.js";
import { quantity } from "./numbers.js";
import { shownNumber } from "./number_text.js";

/** @typedef {import("./contents.js").StoryTable} StoryTable */
/** @typedef {import("../page/block.js").Block} Block */

export const NOT_YET = "-";

export class Step {
  /**
   * @param {import("./panel.js").StoryPanel} panel
   * @param {StoryTable} step
   * @param {{answer(choice: number): void, goOn(): void, did(): void}} act
   */
  constructor(panel, step, act) {
    this.panel = panel;
    this.step = step;
    this.act = act;
    this.hasTried = false;
    const { look, predict, explanation, number } = step;
    this.needsPeriod = [number, ...step.try.done ?? []].some((each) => each.quantity === "response_period");
    this.head = el("h3", { tabindex: "-1" }, tr(step.title));
    this.form = this.makeForm(predict);
    this.reply = el("p", { class: "story-reply", role: "status" });
    this.trial = el("section", { hidden: true }, el("h4", {}, t("storyTry")), el("p", {}, tr(step.try.text)));
    this.done = el("p", { class: "story-reply right", role: "status" });
    this.anyway = el("button", { type: "button", class: "plain", on: { click: () => act.goOn() } },
      t("storyAnyway"));
    this.trial.append(this.done, this.anyway);
    this.number = el("strong", {});
    this.why = el("section", { hidden: true }, el("h4", {}, t("storyWhy")), el("p", {}, tr(explanation.text)));
    this.one = el("p", { class: "story-number" }, el("span", {}, tr(number.label)), this.number);
    this.root = el("div", { class: "story-step" }, this.head, el("p", {}, tr(look.text)),
      this.form, this.reply, this.trial, this.one, this.why);
  }

  /** @param {StoryTable} predict */
  makeForm({ question, choices }) {
    const name = freshId();
    const radios = choices.map((/** @type {StoryTable} */ choice, /** @type {number} */ i) =>
      el("label", { class: "check" },
        el("input", { type: "radio", name, value: String(i + 1), required: true }), local(tr(choice.text))));
    return el("form", { on: { submit: (/** @type {SubmitEvent} */ event) => {
      event.preventDefault();
      this.act.answer(Number(new FormData(this.form).get(name)));
    } } }, el("h4", {}, t("storyPredict")),
    el("fieldset", {}, el("legend", {}, tr(question)), ...radios),
    el("button", { type: "submit" }, t("storyCheck")));
  }

  /**
   * Show how far the reader is.
   * @param {string} answer digit of the choice, or `NOT_YET`
   * @param {boolean} hasTried or goes on without
   */
  show(answer, hasTried) {
    this.hasTried = hasTried;
    const choice = this.step.predict.choices[Number(answer) - 1];
    if (choice) {
      const radio = this.form.querySelector(`input[value="${answer}"]`);
      /** @type {HTMLInputElement} */ (radio).checked = true;
    }
    const reply = choice ? t(choice.right ? "storyRight" : "storyWrong", { text: tr(choice.answer) }) : "";
    if (this.reply.textContent !== reply) this.reply.textContent = reply;
    this.reply.classList.toggle("right", Boolean(choice?.right));
    this.anyway.hidden = hasTried;
    const opened = [this.trial, this.why].filter((part, i) => part.hidden && choice && (i === 0 || hasTried));
    this.trial.hidden = this.one.hidden = !choice;
    this.why.hidden = !choice || !hasTried;
    opened.at(-1)?.scrollIntoView({ block: "nearest" });
  }

  /**
   * Show the number of a run, and whether it does what was to be tried.
   * @param {Block | null} block null for a run that cannot be computed
   * @param {Record<string, string>} extra
   */
  update(block, extra) {
    const { registry } = this.panel.page;
    const { schema } = this.panel;
    const { quantity: name, angle } = this.step.number;
    const value = block ? quantity(name, block, this.angle(angle)) : NaN;
    this.number.textContent = block ? shownNumber(name, value, schema.quantities[name])
      : t(this.panel.page.store.state.view === "map" ? "storyNoPoint" : "storyNoRun");
    this.number.classList.toggle("none", Number.isNaN(value));
    this.number.dataset.value = String(value);
    const isDone = !this.trial.hidden && this.step.try.done?.every((/** @type {StoryTable} */ condition) => {
      if (condition.address) return condition.address in extra;
      if (!block) return false;
      const unit = condition.quantity ? schema.quantities[condition.quantity]
        : registry.options[condition.parameter].unit;
      const end = (/** @type {string} */ name, /** @type {number} */ otherwise) =>
        (name in condition ? toSi(registry, name, condition[name], unit) : otherwise);
      const now = condition.quantity ? quantity(condition.quantity, block, this.angle(condition.angle))
        : parameterOf(condition.parameter, block);
      return now >= end("at_least", -Infinity) && now <= end("at_most", Infinity);
    });
    const done = isDone ? t("storyTried") : "";
    if (this.done.textContent !== done) this.done.textContent = done;
    if (isDone && !this.hasTried) this.act.did();
  }

  /** @param {string | undefined} text */
  angle(text) {
    return text === undefined ? NaN : toSi(this.panel.page.registry, "angle", text, "rad");
  }
}
