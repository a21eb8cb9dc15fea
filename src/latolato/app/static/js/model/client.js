/** Runs that the page asks for, computed in a worker. */

import { askBlock } from "../shared/api.js";
import { InputError } from "./rules.js";

/** @typedef {import("./options.js").Request} Request */
/** @typedef {import("../shared/block.js").Block} Block */

// Samples of a run that is drawn.
export const MOST_SAMPLES = 30_000;
// A run that is no longer wanted may take so long before its worker is ended.
const PATIENCE = 200; // ms

/** Computes runs one after the other; a newer request takes the place of an older one. */
export class Runner {
  /** @param {import("./registry.js").Registry} registry */
  constructor(registry) {
    this.registry = registry;
    /** @type {Worker | null} */
    this.worker = null;
    this.number = 0;
    /** @type {{number: number, request: Request, resolve: (block: Block) => void, reject: (error: Error) => void,
     *   begun: number} | null} */
    this.pending = null;
  }

  /** Begin to load the worker and what it computes with. */
  start() {
    if (this.worker) return this.worker;
    this.worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    this.worker.addEventListener("message", ({ data }) => this.receive(data));
    this.worker.addEventListener("error", (event) => {
      const { pending } = this;
      this.end();
      pending?.reject(new Error(event.message || "the computation ended unexpectedly"));
    });
    return this.worker;
  }

  /**
   * Return a run as a block.
   * @param {Request} request
   * @param {{mostSamples?: number}} [how]
   * @returns {Promise<Block>}
   * @throws {InputError} for bad input
   */
  compute(request, { mostSamples = MOST_SAMPLES } = {}) {
    this.stop();
    this.number += 1;
    const { number } = this;
    return new Promise((resolve, reject) => {
      this.pending = { number, request, resolve, reject, begun: performance.now() };
      this.start().postMessage({ number, request, mostSamples });
    });
  }

  /** Forget what is computed now. */
  stop() {
    const { pending } = this;
    if (!pending) return;
    this.pending = null;
    pending.reject(aborted());
    if (performance.now() - pending.begun > PATIENCE) this.end();
  }

  /** End the worker; the next run begins another one. */
  end() {
    this.worker?.terminate();
    this.worker = null;
    this.pending = null;
  }

  /** @param {{number: number, block?: Block, fault?: any}} answer */
  receive({ number, block, fault }) {
    const { pending } = this;
    if (pending?.number !== number) return;
    this.pending = null;
    if (block) pending.resolve(block);
    else if (fault.isBeyond && this.registry.server) {
      askBlock("api/run", pending.request).then((answer) => {
        if (number === this.number) pending.resolve(answer);
        else pending.reject(aborted());
      }, pending.reject);
    } else pending.reject(fault.about ? new InputError(fault.about.rule, fault.about.about)
      : new Error(fault.message));
  }
}

/** Return what a run ends with that is no longer wanted. */
function aborted() {
  return new DOMException("a newer run is wanted", "AbortError");
}
