/** Runs beside the page: each message is a request, each answer a block or what is wrong. */

import { blockOf } from "./block.js";
import { loadRegistry } from "./registry.js";
import { BeyondPageError, InputError } from "./rules.js";
import { specify } from "./case.js";
import { run } from "./simulate.js";

// Steps of a run in a page: a few seconds.
const MOST_STEPS = 5e6;

self.addEventListener("message", async ({ data: { number, request, mostSamples } }) => {
  try {
    const block = blockOf(run(await specify(await loadRegistry(), request), { mostSamples, mostSteps: MOST_STEPS }));
    const buffers = new Set(Object.values(block.arrays).map((array) => array.buffer));
    self.postMessage({ number, block }, { transfer: [...buffers] });
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    const about = error instanceof InputError ? { rule: error.rule, about: error.about } : null;
    const isBeyond = error instanceof BeyondPageError;
    self.postMessage({ number, fault: { message, about, isBeyond } });
  }
});
