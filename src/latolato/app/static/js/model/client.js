/** Runs for the page, computed in a worker, or in the page itself where workers are refused. */

import { askBlock } from "../shared/api.js";
import { tell } from "../shared/dom.js";
import { t } from "../strings.js";
import { commandLine, pythonLines } from "./lines.js";
import { InputError } from "./rules.js";

/** @typedef {import("./options.js").Request} Request */
/** @typedef {import("./answer.js").Question} Question */
/** @typedef {import("./answer.js").Answer} Answer */
/** @typedef {import("../shared/block.js").Block} Block */
/**
 * A question, and who waits for the answer.
 * @typedef {{question: Question, isRepeated: boolean, resolve: (block: Block) => void,
 *   reject: (error: Error) => void}} Pending
 */

// Samples of a run that is drawn.
export const MOST_SAMPLES = 30_000;
// Runs that are no longer wanted may take so long before their worker is ended.
const PATIENCE = 200; // ms

/** A run that takes longer than a minute and that the user has not agreed to. */
export class LongRunError extends Error {
  /** @param {number} seconds */
  constructor(seconds) {
    super(t("longRun", { count: Math.ceil(seconds / 60) }));
    this.name = "LongRunError";
    this.seconds = seconds;
  }
}

/** Takes the place of a worker in pages where workers are refused. */
class Inline {
  /** @param {(answer: Answer) => void} receive */
  constructor(receive) {
    this.receive = receive;
  }

  /** @param {Question} question */
  async postMessage(question) {
    const { answer } = await import("./answer.js");
    this.receive(await answer(question));
  }

  terminate() {}
}

/** Computes runs one after the other; a newer request takes the place of an older one. */
export class Runner {
  /** @param {import("./registry.js").Registry} registry */
  constructor(registry) {
    this.registry = registry;
    /** @type {Worker | Inline | null} */
    this.worker = null;
    /** Whether the worker has begun to answer: one that still loads is not ended. */
    this.isReady = false;
    this.number = 0;
    /** @type {Pending | null} */
    this.pending = null;
    this.unanswered = 0;
    this.busySince = 0;
  }

  /** Begin to load the worker and what it computes with. */
  start() {
    this.worker ??= this.startWorker();
    return this.worker;
  }

  startWorker() {
    let worker;
    try {
      worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    } catch {
      return this.startInline(); // refused by the page's policy or by the browser
    }
    this.isReady = false;
    worker.addEventListener("message", ({ data }) => {
      this.isReady = true;
      if (data) this.receive(data);
    });
    worker.addEventListener("error", ({ message }) => {
      if (this.isReady) {
        this.restart(message);
        return;
      }
      this.worker = this.startInline();
      if (this.pending) void this.worker.postMessage(this.pending.question);
    });
    return worker;
  }

  startInline() {
    return new Inline((answer) => this.receive(answer));
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
    const question = { number: this.number, request, mostSamples, isAgreed };
    return new Promise((resolve, reject) => {
      this.pending = { question, resolve, reject, isRepeated: false };
      this.post(question);
    });
  }

  /** @param {Question} question */
  post(question) {
    if (!this.unanswered) this.busySince = performance.now();
    this.unanswered += 1;
    void this.start().postMessage(question);
  }

  /** Forget what is computed now. */
  stop() {
    this.pending?.reject(aborted());
    this.pending = null;
    const isSlow = this.unanswered > 0 && performance.now() - this.busySince > PATIENCE;
    if (this.isReady && isSlow) this.end();
  }

  /** End the worker; the next run begins another one. */
  end() {
    this.worker?.terminate();
    this.worker = null;
    this.pending = null;
    this.unanswered = 0;
  }

  /**
   * Put another worker in the place of one that failed, and give it the same question once more.
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
    this.post(pending.question);
  }

  /** @param {Answer} answer */
  receive({ number, block, seconds, fault }) {
    this.unanswered -= 1;
    this.busySince = performance.now();
    const { pending } = this;
    if (pending?.question.number !== number) return;
    if (fault && !fault.about) {
      this.restart(fault.message);
      return;
    }
    this.pending = null;
    if (block) pending.resolve(block);
    else if (seconds) pending.reject(new LongRunError(seconds));
    else if (fault?.isBeyond && this.registry.server) {
      this.askProgram(pending.question).then((whole) => {
        if (number === this.number) pending.resolve(whole);
        else pending.reject(aborted());
      }, pending.reject);
    } else pending.reject(new InputError(fault?.about.rule, fault?.about.about));
  }

  /**
   * Return a run that pages do not compute, from the program that serves this one.
   * @param {Question} question
   */
  async askProgram({ request, mostSamples }) {
    const { about, ...columns } = await askBlock("api/run", { ...request, most_samples: mostSamples });
    const { options } = about;
    return { ...columns, about: { ...about, python: pythonLines(this.registry, options),
      command: commandLine(this.registry, options) } };
  }
}

/** Return what a run ends with that is no longer wanted. */
function aborted() {
  return new DOMException("a newer run is wanted", "AbortError");
}
