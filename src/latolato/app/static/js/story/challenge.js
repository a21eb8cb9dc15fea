/** A challenge: a task, and the score of what the reader found. */

import { toSi } from "../model/options.js";
import { InputError } from "../model/rules.js";
import { el } from "../shared/dom.js";
import { Knob } from "../shared/knob.js";
import { t, tr } from "../strings.js";
import { edgesOf, requestOf, scoreOfGuess, scoreOfRun } from "./scores.js";
import { withUnit } from "./words.js";

/** @typedef {import("./check.js").Table} Table */
/** @typedef {import("../shared/block.js").Block} Block */

// Scores in addresses are rounded to so many digits, and may be off by this share.
const DIGITS = 4;
const ROUNDING = 1e-3;
export const SCORE = "story.score";
const GUESS = "story.guess";
const MILLIMETRE = { name: "mm", size: 1e-3 };

export class Challenge {
  /**
   * @param {import("./panel.js").StoryPanel} panel
   * @param {Table} challenge
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
    this.claim = el("p", { class: "story-reply", role: "status" });
    this.keep = el("button", { type: "button", disabled: true, on: { click: () => this.keepScore() } }, t("storyKeep"));
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
      this.isGuess && this.makeForm(), this.result, this.edges, this.note,
      !this.isGuess && this.keep, this.claim);
  }

  makeForm() {
    // A refusal that went only when its field is left would move the button away from under the pointer.
    const forget = () => this.guesses.forEach((knob) => knob.forget());
    return el("form", { on: { input: forget, submit: (/** @type {Event} */ event) => {
      event.preventDefault();
      for (const knob of this.guesses) knob.type();
      const wrong = this.guesses.find((knob) => knob.isRefused);
      if (wrong) return wrong.input.focus();
      const guess = this.guesses.map((knob) => knob.textOf(Number(knob.value))).join(", ");
      this.score = scoreOfGuess(this.panel.page.registry, this.challenge, guess);
      this.keepScore({ [GUESS]: guess });
    } } }, ...this.guesses.map(({ root }) => root), el("button", { type: "submit" }, t("storyGuessCheck")));
  }

  /**
   * Put the score into the address.
   * @param {Record<string, string>} [more] what else the address keeps
   */
  keepScore(more = {}) {
    const { store } = this.panel.page;
    const size = this.unit === "m" ? 1e-3 : 1;
    const text = `${Number((this.score / size).toPrecision(DIGITS))} ${this.unit === "m" ? "mm" : this.unit}`;
    this.claimed = text;
    store.set({ extra: { ...store.state.extra, ...more, [SCORE]: text } }, "extra");
    this.claim.scrollIntoView({ block: "nearest" });
  }

  /** Return the run that counts. */
  request() {
    const { registry, store } = this.panel.page;
    return requestOf(registry, this.challenge, store.state.options);
  }

  /**
   * Show the score of a run, and whether it is the one that the address claims.
   * @param {Block | null} block
   * @param {Record<string, string>} extra
   */
  heed(block, extra) {
    const { registry } = this.panel.page;
    const { task } = this.challenge;
    try {
      if (this.isGuess) this.heedGuess(extra[GUESS]);
      else this.score = block ? scoreOfRun(registry, task, block) : NaN;
    } catch (error) {
      if (!(error instanceof InputError)) throw error;
      this.score = NaN;
    }
    const text = withUnit(this.score, this.unit);
    const isNone = Number.isNaN(this.score);
    const result = isNone ? (this.isGuess ? "" : t("storyNotYet"))
      : t(this.score <= this.par ? "storyReached" : "storyScore", { text });
    if (this.result.textContent !== result) this.result.textContent = result;
    this.result.dataset.value = String(this.score);
    this.keep.disabled = isNone;
    this.note.textContent = this.others();
    this.heedClaim(extra[SCORE], text);
  }

  /** @param {string | undefined} guess */
  heedGuess(guess) {
    const { registry } = this.panel.page;
    this.score = NaN;
    this.edges.textContent = "";
    if (guess === undefined) return;
    this.score = scoreOfGuess(registry, this.challenge, guess);
    guess.split(",").forEach((part, i) => this.guesses[i].show(toSi(registry, "guess", part.trim(), "m")));
    const edges = edgesOf(registry, this.challenge);
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

  /**
   * Say whether the score in the address is right.
   * @param {string | undefined} claimed
   * @param {string} text of the score
   */
  heedClaim(claimed, text) {
    let words = "";
    let isRight = true;
    if (claimed !== undefined) {
      const value = this.valueOf(claimed);
      isRight = Math.abs(value - this.score) <= ROUNDING * Math.abs(this.score);
      words = isRight ? t(claimed === this.claimed ? "storyKept" : "storyHolds")
        : t(Number.isNaN(this.score) ? "storyForgedNone" : "storyForged", { claimed, text });
    }
    if (this.claim.textContent !== words) this.claim.textContent = words;
    this.claim.classList.toggle("right", isRight);
  }

  /** @param {string} claimed */
  valueOf(claimed) {
    try {
      return toSi(this.panel.page.registry, "score", claimed, this.unit);
    } catch (error) {
      if (!(error instanceof InputError)) throw error;
      return NaN;
    }
  }
}
