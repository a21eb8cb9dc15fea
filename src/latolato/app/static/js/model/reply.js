/** The answer to a request for a run: a block or an error. */

import { blockOf } from "./run_block.js";
import { loadRegistry } from "./registry.js";
import { BeyondPageError, InputError } from "./rules.js";
import { specify } from "./case.js";
import { run } from "./simulate.js";

/**
 * A question with a stretch is for a run of few samples, most of them in that stretch of time [s].
 * @typedef {{number: number, request: import("./options.js").OptionsRequest, mostSamples: number,
 *   stretch: [number, number] | null}} RunQuestion
 */
/** @typedef {{number: number, block?: import("../page/block.js").Block,
 *   fault?: {message: string, about: any, isBeyond: boolean}}} Reply */

/**
 * @param {RunQuestion} question
 * @returns {Promise<Reply>}
 */
export async function answer({ number, request, mostSamples, stretch }) {
  try {
    const each = await specify(await loadRegistry(), request);
    return { number, block: blockOf(run(each, mostSamples, stretch)) };
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    const about = error instanceof InputError ? { rule: error.rule, about: error.about } : null;
    return { number, fault: { message, about, isBeyond: error instanceof BeyondPageError } };
  }
}
