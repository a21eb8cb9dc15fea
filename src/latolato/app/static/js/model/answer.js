/** What becomes of a request for a run: a block or what is wrong, as threads hand them on. */

import { blockOf } from "./block.js";
import { loadRegistry } from "./registry.js";
import { BeyondPageError, InputError } from "./rules.js";
import { specify } from "./case.js";
import { run } from "./simulate.js";

/** @typedef {{number: number, request: import("./options.js").Request, mostSamples: number}} Question */
/** @typedef {{number: number, block?: import("../shared/block.js").Block,
 *   fault?: {message: string, about: any, isBeyond: boolean}}} Answer */

// Steps of a run in a page: a few seconds.
const MOST_STEPS = 5e6;

/**
 * @param {Question} question
 * @returns {Promise<Answer>}
 */
export async function answer({ number, request, mostSamples }) {
  try {
    const specified = await specify(await loadRegistry(), request);
    return { number, block: blockOf(run(specified, { mostSamples, mostSteps: MOST_STEPS })) };
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    const about = error instanceof InputError ? { rule: error.rule, about: error.about } : null;
    return { number, fault: { message, about, isBeyond: error instanceof BeyondPageError } };
  }
}
