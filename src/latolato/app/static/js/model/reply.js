/** The answer to a request for a run: a block, its duration if that is long, or an error. */

import { blockOf } from "./run_block.js";
import { loadRegistry } from "./registry.js";
import { BeyondPageError, InputError } from "./rules.js";
import { specify } from "./case.js";
import { run, secondsOf } from "./simulate.js";

/**
 * A question with a stretch is for a run of few samples, most of them in that stretch of time [s].
 * @typedef {{number: number, request: import("./options.js").OptionsRequest, mostSamples: number,
 *   isAgreed: boolean, stretch: [number, number] | null}} RunQuestion
 */
/** @typedef {{number: number, block?: import("../page/block.js").Block, seconds?: number,
 *   fault?: {message: string, about: any, isBeyond: boolean}}} Reply */

// A longer run is computed if the user agrees.
const LONG = 60; // s

/**
 * @param {RunQuestion} question
 * @returns {Promise<Reply>}
 */
export async function answer({ number, request, mostSamples, isAgreed, stretch }) {
  try {
    const each = await specify(await loadRegistry(), request);
    const seconds = isAgreed ? 0 : secondsOf(each);
    if (seconds > LONG) return { number, seconds };
    return { number, block: blockOf(run(each, mostSamples, stretch)) };
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    const about = error instanceof InputError ? { rule: error.rule, about: error.about } : null;
    return { number, fault: { message, about, isBeyond: error instanceof BeyondPageError } };
  }
}
