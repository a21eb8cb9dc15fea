/** A challenge: a task, and the score of what the reader found. */

import { toSi } from "../model/units.js";
import { InputError } from "../model/rules.js";
import { el } from "../page/dom.js";
import { Knob } from "../page/knob.js";
import { t, tr } from "../strings.js";
import { tongueAmplitudes, challengeRequest, scoreOfGuess, scoreOfRun } from "./scores.js";
import { withUnit } from "./number_text.js";

/** @typedef {import("./contents.js").StoryTable} StoryTable */
/** @typedef {import("../page/block.js").Block} Block */

const GUESS = "story.guess";
const MILLIMETRE = { name: "mm", size: 1e-3 };

export class Challenge {
  /**
   * @param {import("./panel.js").StoryPanel} panel
   * @param {StoryTable} challenge
   */
  constructor(panel, challenge) {
    this.panel = panel;
    this.challenge = challenge;
    const { look, task } = challenge;
    this.unit = panel.schema.rules[task.rule];
    this.par = toSi(panel.page.registry, "par", task.par, this.unit);
    /** @type {number} score of what is on show [SI] */
    this.score = NaN;
    this.isGuess = task.rule === "guess_tongue";
    this.head = el("h3", { tabindex: "-1" }, t("storyTask"));
    this.result = el("p", { class: "story-number", role: "status" });
    this.note = el("p", { class: "hint" });
    this.edges = el("p", { class: "hint" });
    const { drive_amplitude: option } = panel.page.registry.options;
    const guessed = { ...option, symbol: "", suggested: null, units: [MILLIMETRE] };
    /** @type {Knob[]} */
    this.guesses = task.ratios?.map((/** @type {number} */ ratio, /** @type {number} */ i) =>
      new Knob("drive_amplitude", guessed, { label: t("storyGuess", { ratio }), registry: panel.page.registry,
        take: (_, value) => this.guesses[i].show(Number(value)) }));
    this.root = el("div", { class: "story-step" }, this.head, el("p", {}, tr(look.text)),
      el("p", {}, tr(task.text)),
      el("p", {}, t("storyGoal", { text: withUnit(this.par, this.unit) })),
      this.isGuess && this.makeForm(), this.result, this.edges, this.note);
  }

  makeForm() {
    // A refusal that went only when its field is left would move the button away from under the pointer.
    const forget = () => this.guesses.forEach((knob) => knob.forget());
    return el("form", { on: { input: forget, submit: (/** @type {Event} */ event) => {
      event.preventDefault();
      for (const knob of this.guesses) knob.type();
      const wrong = this.guesses.find((knob) => knob.isRefused);
      if (wrong) {
        wrong.input.focus();
        // Its error lies below the field.
        wrong.root.scrollIntoView({ block: "nearest" });
        return;
      }
      const guess = this.guesses.map((knob) => knob.textOf(Number(knob.value))).join(", ");
      this.panel.page.store.keep(GUESS, guess);
      this.result.scrollIntoView({ block: "nearest" });
    } } }, ...this.guesses.map(({ root }) => root), el("button", { type: "submit" }, t("storyGuessCheck")));
  }

  /** Return the run that counts. */
  request() {
    const { registry, store } = this.panel.page;
    return challengeRequest(registry, this.challenge, store.state.options);
  }

  /**
   * Show the score of a run.
   * @param {Block | null} block
   * @param {Record<string, string>} extra
   */
  update(block, extra) {
    const { registry } = this.panel.page;
    const { task } = this.challenge;
    try {
      if (this.isGuess) this.updateGuess(extra[GUESS]);
      else this.score = block ? scoreOfRun(registry, task, block) : NaN;
    } catch (error) {
      if (!(error instanceof InputError)) throw error;
      this.score = NaN;
    }
    const text = withUnit(this.score, this.unit);
    const result = Number.isNaN(this.score) ? (this.isGuess ? "" : t("storyNotYet"))
      : t(this.score <= this.par ? "storyReached" : "storyScore", { text });
    if (this.result.textContent !== result) this.result.textContent = result;
    this.result.dataset.value = String(this.score);
    this.note.textContent = this.others();
  }

  /** @param {string | undefined} guess */
  updateGuess(guess) {
    const { registry } = this.panel.page;
    this.score = NaN;
    this.edges.textContent = "";
    if (guess === undefined) return;
    this.score = scoreOfGuess(registry, this.challenge, guess);
    guess.split(",").forEach((part, i) => this.guesses[i].show(toSi(registry, "guess", part.trim(), "m")));
    const edges = tongueAmplitudes(registry, this.challenge);
    this.edges.textContent = t("storyEdges", { list: edges.map((edge, i) => t("storyEdge",
      { ratio: this.challenge.task.ratios[i], text: withUnit(edge, "m") })).join(", ") });
  }

  /** Return which options of the reader do not count, in a sentence. */
  others() {
    const { store, registry } = this.panel.page;
    const { look, task } = this.challenge;
    const names = Object.entries(store.state.options).filter(([name, value]) =>
      !task.free.includes(name) && String(look.options?.[name]) !== value && registry.options[name])
      .map(([name]) => registry.options[name].label);
    return names.length && !this.isGuess ? t("storyOthers", { names: names.join(", ") }) : "";
  }
}
