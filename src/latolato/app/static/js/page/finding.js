/** An answer in words: its first sentence is a headline. */

import { el } from "./dom.js";

/** Return an empty place for an answer, which screen readers read when it comes. */
export function findingPlace() {
  return el("p", { class: "finding", role: "status" });
}

/**
 * Show an answer; without one its place says what will stand there.
 * @param {HTMLElement} place
 * @param {string} text
 * @param {boolean} isAnswer
 */
export function showFinding(place, text, isAnswer) {
  place.classList.toggle("waiting", !isAnswer);
  // A number stays in one line with its uncertainty.
  const whole = text.replaceAll(" ± ", "\u00a0±\u00a0");
  const end = whole.search(/(?<=[.!?]) (?=\p{Lu})/u);
  const [headline, beside] = end < 0 ? [whole, ""] : [whole.slice(0, end), whole.slice(end)];
  if (!isAnswer) place.textContent = whole;
  else place.replaceChildren(el("strong", {}, headline), beside);
}
