/** Says what an answer waits for if it does not come at once. */

import { t } from "../strings.js";
import { askJson } from "./api.js";

const PATIENCE = 700; // ms without a word
const AGAIN = 1000; // ms

/**
 * Return the answer; until it is there, an element says that the server computes or compiles.
 * @template T
 * @param {HTMLElement} place its text is taken away in the end
 * @param {Promise<T>} answer
 * @returns {Promise<T>}
 */
export async function waited(place, answer) {
  let message = "";
  let over = false;
  /** @type {ReturnType<typeof setTimeout>} */
  let timer;
  const say = async () => {
    // A server that says nothing is the answer's own affair.
    const state = await askJson("api/compiling").catch(() => null);
    if (over) return;
    if (state) {
      message = t(state.compiling ? "preparing" : "computing");
      if (place.textContent !== message) place.textContent = message;
    }
    timer = setTimeout(say, AGAIN);
  };
  timer = setTimeout(say, PATIENCE);
  try {
    return await answer;
  } finally {
    over = true;
    clearTimeout(timer);
    if (message && place.textContent === message) place.textContent = "";
  }
}
