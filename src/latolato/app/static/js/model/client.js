/** Runs that the page asks for, computed in a worker. */

import { askBlock } from "../shared/api.js";
import { tell } from "../shared/dom.js";
import { t } from "../strings.js";
import { InputError } from "./rules.js";

/** @typedef {import("./options.js").Request} Request */
/** @typedef {import("../shared/block.js").Block} Block */
/**
 * What a worker is asked, and who waits for the answer.
 * @typedef {{message: {number: number, request: Request, mostSamples: number, isAgreed: boolean},
 *   isRepeated: boolean, resolve: (block: Block) => void, reject: (error: Error) => void}} Pending
 */

// Samples of a run that is drawn.
export const MOST_SAMPLES = 30_000;
// Runs that are no longer wanted may take so long before their worker is ended.
const PATIENCE = 200; // ms

/** A run that takes longer than a minute, to which nobody has agreed. */
export class LongRunError extends Error {
  /** @param {number} seconds */
  constructor(seconds) {
    super(t("longRun", { count: Math.ceil(seconds / 60) }));
    this.name = "LongRunError";
    this.seconds = seconds;
  }
}

/** Computes runs one after the other; a newer request takes the place of an older one. */
export class Runner {
  /** @param {import("./registry.js").Registry} registry */
  constructor(registry) {
    this.registry = registry;
    /** @type {Worker | null} */
    this.worker = null;
    this.number = 0;
    /** @type {Pending | null} */
    this.pending = null;
    this.unanswered = 0;
    this.busySince = 0;
  }

  /** Begin to load the worker and what it computes with. */
  start() {
    if (this.worker) return this.worker;
    this.worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    this.worker.addEventListener("message", ({ data }) => this.receive(data));
    this.worker.addEventListener("error", ({ message }) => this.restart(message));
    return this.worker;
  }

  /**
   * Return a run as a block.
   * @param {Request} request
   * @param {{mostSamples?: number, isAgreed?: boolean}} [how] `isAgreed`: however long it takes
   * @returns {Promise<Block>}
   * @throws {InputError} for bad input
   * @throws {LongRunError} for a run that takes longer than a minute
   */
  compute(request, { mostSamples = MOST_SAMPLES, isAgreed = false } = {}) {
    this.stop();
    this.number += 1;
    const message = { number: this.number, request, mostSamples, isAgreed };
    return new Promise((resolve, reject) => {
      this.pending = { message, resolve, reject, isRepeated: false };
      this.post(message);
    });
  }

  /** @param {Pending["message"]} message */
  post(message) {
    if (!this.unanswered) this.busySince = performance.now();
    this.unanswered += 1;
    this.start().postMessage(message);
  }

  /** Forget what is computed now. */
  stop() {
    this.pending?.reject(aborted());
    this.pending = null;
    if (this.unanswered && performance.now() - this.busySince > PATIENCE) this.end();
  }

  /** End the worker; the next run begins another one. */
  end() {
    this.worker?.terminate();
    this.worker = null;
    this.pending = null;
    this.unanswered = 0;
  }

  /**
   * Put another worker in the place of one that failed, and give it the same request once more.
   * @param {string} [reason]
   */
  restart(reason) {
    const { pending } = this;
    this.end();
    if (!pending) return;
    if (pending.isRepeated) {
      pending.reject(new Error(reason || t("workerGone")));
      return;
    }
    tell(t("workerAgain"));
    this.pending = { ...pending, isRepeated: true };
    this.post(pending.message);
  }

  /** @param {{number: number, block?: Block, seconds?: number, fault?: any}} answer */
  receive({ number, block, seconds, fault }) {
    this.unanswered -= 1;
    this.busySince = performance.now();
    const { pending } = this;
    if (pending?.message.number !== number) return;
    if (fault && !fault.about) {
      this.restart(fault.message);
      return;
    }
    this.pending = null;
    if (block) pending.resolve(block);
    else if (seconds) pending.reject(new LongRunError(seconds));
    else if (fault.isBeyond && this.registry.server) {
      askBlock("api/run", pending.message.request).then((answer) => {
        if (number === this.number) pending.resolve(answer);
        else pending.reject(aborted());
      }, pending.reject);
    } else pending.reject(new InputError(fault.about.rule, fault.about.about));
  }
}

/** Return what a run ends with that is no longer wanted. */
function aborted() {
  return new DOMException("a newer run is wanted", "AbortError");
}
