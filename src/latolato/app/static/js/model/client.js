/** Runs that the page asks for, computed in a worker, or in the page where it may have none. */

import { askBlock } from "../shared/api.js";
import { commandLine, pythonLines } from "./lines.js";
import { InputError } from "./rules.js";

/** @typedef {import("./options.js").Request} Request */
/** @typedef {import("./answer.js").Question} Question */
/** @typedef {import("./answer.js").Answer} Answer */
/** @typedef {import("../shared/block.js").Block} Block */

// Samples of a run that is drawn.
export const MOST_SAMPLES = 30_000;
// A run that is no longer wanted may take so long before its worker is ended.
const PATIENCE = 200; // ms

/** Takes the place of a worker in pages that may have none. */
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
    /** @type {{question: Question, resolve: (block: Block) => void, reject: (error: Error) => void,
     *   begun: number} | null} */
    this.pending = null;
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
    worker.addEventListener("error", (event) => {
      const { pending } = this;
      if (!this.isReady) {
        this.worker = this.startInline();
        if (pending) void this.worker.postMessage(pending.question);
        return;
      }
      this.end();
      pending?.reject(new Error(event.message || "the computation ended unexpectedly"));
    });
    return worker;
  }

  startInline() {
    return new Inline((result) => this.receive(result));
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
    const question = { number: this.number, request, mostSamples };
    return new Promise((resolve, reject) => {
      this.pending = { question, resolve, reject, begun: performance.now() };
      void this.start().postMessage(question);
    });
  }

  /** Forget what is computed now. */
  stop() {
    const { pending } = this;
    if (!pending) return;
    this.pending = null;
    pending.reject(aborted());
    if (this.isReady && performance.now() - pending.begun > PATIENCE) this.end();
  }

  /** End the worker; the next run begins another one. */
  end() {
    this.worker?.terminate();
    this.worker = null;
    this.pending = null;
  }

  /** @param {Answer} answer */
  receive({ number, block, fault }) {
    const { pending } = this;
    if (pending?.question.number !== number) return;
    this.pending = null;
    if (block) pending.resolve(block);
    else if (fault?.isBeyond && this.registry.server) {
      this.askProgram(pending.question).then((whole) => {
        if (number === this.number) pending.resolve(whole);
        else pending.reject(aborted());
      }, pending.reject);
    } else pending.reject(fault?.about ? new InputError(fault.about.rule, fault.about.about)
      : new Error(fault?.message));
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
