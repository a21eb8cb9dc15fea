/** Runs beside the page: each message is a request, each answer a block, how long the run takes if that
 * is long, or what is wrong. */

import { loadLayout, loadModule } from "../kernels/load.js";
import { blockOf } from "./block.js";
import { loadRegistry } from "./registry.js";
import { BeyondPageError, InputError } from "./rules.js";
import { specify } from "./case.js";
import { run, secondsOf } from "./simulate.js";

// A longer run is computed if whoever wants it agrees.
const LONG = 60; // s

// What most runs need comes at once; a run that needs it tells of a fault.
for (const load of [loadRegistry, loadLayout, () => loadModule("one")]) load().catch(() => {});

self.addEventListener("message", async ({ data: { number, request, mostSamples, isAgreed } }) => {
  try {
    const each = await specify(await loadRegistry(), request);
    const seconds = isAgreed ? 0 : secondsOf(each);
    if (seconds > LONG) {
      self.postMessage({ number, seconds });
      return;
    }
    const block = blockOf(run(each, mostSamples));
    const buffers = new Set(Object.values(block.arrays).map((array) => array.buffer));
    self.postMessage({ number, block }, { transfer: [...buffers] });
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    const about = error instanceof InputError ? { rule: error.rule, about: error.about } : null;
    const isBeyond = error instanceof BeyondPageError;
    self.postMessage({ number, fault: { message, about, isBeyond } });
  }
});
