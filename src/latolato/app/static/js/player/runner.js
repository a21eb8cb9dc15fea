/** Runs for the page, computed in a worker, or in the page itself where workers are refused. */

import { InputError } from "../model/rules.js";
import { beginWorker } from "../model/worker.js";
import { t } from "../strings.js";

/** @typedef {import("../model/options.js").OptionsRequest} OptionsRequest */
/** @typedef {import("../model/reply.js").RunQuestion} RunQuestion */
/** @typedef {import("../model/reply.js").Reply} Reply */
/** @typedef {import("../page/block.js").Block} Block */
/**
 * A question, and who waits for the answer.
 * @typedef {{question: RunQuestion, resolve: (block: Block) => void, reject: (error: Error) => void}} Pending
 */

// Samples of a run that is drawn.
export const MOST_SAMPLES = 30_000;
// A run may take so long before a newer one ends it.
const PATIENCE = 200; // ms

/** Takes the place of a worker in pages where workers are refused. */
class Inline {
  /** @param {(answer: Reply) => void} receive */
  constructor(receive) {
    this.receive = receive;
  }

  /** @param {RunQuestion} question */
  async postMessage(question) {
    const { answer } = await import("../model/reply.js");
    this.receive(await answer(question));
  }

  terminate() {}
}

/**
 * Computes runs one after the other. The run that is under way is delivered, so that a slider that moves
 * shows runs on its way; of those that wait, the newest only.
 */
export class Runner {
  /**
   * @param {import("../model/registry.js").Registry} registry
   * @param {ReturnType<typeof beginWorker>} [begun] a worker that the page has begun already
   */
  constructor(registry, begun = null) {
    this.registry = registry;
    /** @type {Worker | Inline | null} */
    this.worker = null;
    this.begun = begun;
    /** Whether the worker has begun to answer: one that still loads is not ended. */
    this.isReady = false;
    this.number = 0;
    /** What the worker computes. @type {Pending | null} */
    this.running = null;
    this.busySince = 0;
    /** What it computes next. @type {Pending | null} */
    this.waiting = null;
  }

  startWorker() {
    const begun = this.begun ?? beginWorker();
    this.begun = null;
    if (!begun) return this.startInline();
    const { worker, begins } = begun;
    this.isReady = false;
    begins.then(() => { this.isReady = true; }, () => {
      if (this.worker !== worker) return;
      this.worker = this.startInline();
      if (this.running) void this.worker.postMessage(this.running.question);
    });
    worker.addEventListener("message", ({ data }) => {
      if (data) this.receive(data);
    });
    worker.addEventListener("error", ({ message }) => {
      if (this.isReady) this.fail(message);
    });
    return worker;
  }

  startInline() {
    return new Inline((answer) => this.receive(answer));
  }

  /**
   * Return a run as a block.
   * @param {OptionsRequest} request
   * @param {{mostSamples?: number, stretch?: [number, number] | null}} [how]
   *   `stretch`: with few samples, most of them in that stretch of time [s]
   * @returns {Promise<Block>}
   * @throws {InputError} for bad input
   */
  compute(request, { mostSamples = MOST_SAMPLES, stretch = null } = {}) {
    this.number += 1;
    const question = { number: this.number, request, mostSamples, stretch };
    return new Promise((resolve, reject) => {
      this.waiting?.reject(aborted());
      this.waiting = { question, resolve, reject };
      this.next();
    });
  }

  /** Compute what waits; a run that takes long makes way for it. */
  next() {
    const { waiting, running } = this;
    if (!waiting) return;
    if (running) {
      if (!this.isReady || performance.now() - this.busySince < PATIENCE) {
        setTimeout(() => this.next(), PATIENCE);
        return;
      }
      running.reject(aborted());
      this.endWorker();
    }
    this.waiting = null;
    this.running = waiting;
    this.busySince = performance.now();
    this.worker ??= this.startWorker();
    void this.worker.postMessage(waiting.question);
  }

  /** Forget what is asked for now. */
  stop() {
    this.waiting?.reject(aborted());
    this.waiting = null;
    this.running?.reject(aborted());
  }

  /** End the worker; the next run begins another one. */
  end() {
    this.endWorker();
    this.waiting = null;
  }

  endWorker() {
    this.worker?.terminate();
    this.worker = null;
    this.running = null;
  }

  /**
   * Give up a worker that failed, with its question; the next question begins another worker.
   * @param {string} [reason]
   */
  fail(reason) {
    this.running?.reject(new Error(reason || t("workerGone")));
    this.endWorker();
    this.next();
  }

  /** @param {Reply} answer */
  receive(answer) {
    const { running } = this;
    if (running?.question.number !== answer.number) return;
    if (answer.fault && !answer.fault.about) {
      this.fail(answer.fault.message);
      return;
    }
    this.running = null;
    this.settle(running, answer);
    this.next();
  }

  /**
   * @param {Pending} pending
   * @param {Reply} answer
   */
  settle({ question, resolve, reject }, { number, block, fault }) {
    if (block) resolve(block);
    else if (fault?.isBeyond && this.registry.server) {
      this.askProgram(question).then((whole) => {
        if (number === this.number) resolve(whole);
        else reject(aborted());
      }, reject);
    } else reject(new InputError(fault?.about.rule, fault?.about.about));
  }

  /**
   * Return a run that pages do not compute, from the program that serves this one.
   * @param {RunQuestion} question
   */
  async askProgram({ request, mostSamples }) {
    const [{ commandLine, pythonLines }, { askBlock }] = await Promise.all(
      [import("../model/run_code.js"), import("../page/api.js")]);
    const { about, ...columns } = await askBlock("api/run", { ...request, most_samples: mostSamples })
      .catch((error) => { throw error.input ?? error; });
    const { options } = about;
    return { ...columns, about: { ...about, python: pythonLines(this.registry, options),
      command: commandLine(this.registry, options) } };
  }
}

/** The error that ends a run that is no longer wanted. */
function aborted() {
  return new DOMException("a newer run is wanted", "AbortError");
}
