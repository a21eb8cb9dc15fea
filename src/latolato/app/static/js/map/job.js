/** One map on its way: computed by the workers of the page, or stored and opened by the server. */

import { problemOf } from "../kernels/begin.js";
import { loadLayout } from "../kernels/load.js";
import { specify } from "../model/case.js";
import { InputError, refusal } from "../model/rules.js";
import { doJob } from "../page/jobs.js";
import { beginOf, choicesOf, optionsAt, optionsOfCell } from "./about.js";
import { questionOf } from "./question.js";

/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("./pool.js").Pool} Pool */
/** @typedef {import("./pool.js").Progress} Progress */
/** @typedef {import("./question.js").MapQuestion} MapQuestion */

/**
 * What becomes of a map: what it may be made of, what it is of, its cells as they come, and its end
 * or what is wrong with it. A map that takes long `asks` first, and `start` begins it; `restarted`
 * is called when a worker has died.
 * @typedef {{choices: (choices: import("./about.js").Choices) => void,
 *   begin: (begin: import("./grid.js").Begin) => void, asks: (minutes: number) => void,
 *   cells: (cells: import("./grid.js").Cells, progress: Progress) => void,
 *   restarted: (message: string) => void, done: (progress: Progress) => void,
 *   refused: (error: Error) => void}} JobListener
 */

// A map that takes longer asks first.
const LONG = 60; // s
// A point of more steps would let all wait for it.
const MOST_STEPS = 5e6;

/** A map that the page computes. */
export class PageJob {
  /**
   * @param {Registry} registry
   * @param {Pool} pool
   * @param {import("./question.js").MapRequest} request
   * @param {boolean} agreed whether it may take long
   * @param {JobListener} listener
   */
  constructor(registry, pool, request, agreed, listener) {
    this.registry = registry;
    this.pool = pool;
    this.request = request;
    this.agreed = agreed;
    this.listener = listener;
    this.ended = false;
    const { width, height, stride = 1 } = request;
    /** How many points are computed, of how many. */
    this.count = Math.ceil(width / stride) * Math.ceil(height / stride);
    this.all = width * height;
    /** @type {MapQuestion | null} */
    this.question = null;
    void this.prepare().catch((error) => this.refuse(error));
  }

  async prepare() {
    const question = await questionOf(this.registry, await loadLayout(), this.request);
    if (this.ended) return;
    this.listener.choices(choicesOf(question));
    const estimate = await this.pool.estimate(question.plan);
    if (estimate.problem) await refusePoint(question, estimate.problem);
    if (estimate.longest > MOST_STEPS)
      throw refusal(problemOf(question.layout, "too many steps",
        [estimate.longest, question.duration / estimate.longest, MOST_STEPS]));
    if (this.ended) return;
    this.question = question;
    this.estimate = estimate;
    this.listener.begin(beginOf(question));
    const seconds = (estimate.seconds * this.count) / this.all;
    if (seconds > LONG && !this.agreed) this.listener.asks(Math.ceil(seconds / 60));
    else this.start();
  }

  /** Begin to compute. */
  start() {
    const { listener } = this;
    const { plan } = /** @type {MapQuestion} */ (this.question);
    this.agreed = true;
    void this.pool.start(plan, {
      onCells: listener.cells, onRestart: listener.restarted,
      onDone: (progress) => { this.ended = true; listener.done(progress); },
      onError: (error) => this.refuse(error),
    }, this.estimate, this.request.stride);
  }

  /** @param {Error} error */
  refuse(error) {
    if (this.ended) return;
    this.ended = true;
    this.listener.refused(error);
  }

  /** End the work at once. */
  cancel() {
    this.ended = true;
    this.pool.stop();
  }
}

/**
 * Throw what is wrong with the first point of a map, as Python says it of its run.
 * @param {MapQuestion} question
 * @param {import("../kernels/begin.js").Reported} problem
 */
async function refusePoint(question, problem) {
  // A law may have its own words.
  if (problem.name === "out of range") await specify(question.registry, { options: optionsOfCell(question, 0) });
  throw refusal(problem, problem.name === "transient" ? ["transient", "duration"] : undefined);
}

/** A stored map, which the server opens. */
export class StoredJob {
  /**
   * @param {Registry} registry
   * @param {Record<string, any>} request
   * @param {JobListener} listener
   */
  constructor(registry, request, listener) {
    this.registry = registry;
    this.request = request;
    this.listener = listener;
    this.ended = false;
    this.agreed = true;
    this.question = null;
    this.count = 0;
    this.control = new AbortController();
    void this.open();
  }

  async open() {
    const { listener, registry } = this;
    try {
      const { about, arrays } = await doJob("ws/map/stored", this.request, { signal: this.control.signal });
      const begin = /** @type {import("./grid.js").Begin} */ ({ about, arrays });
      const { options, sets, streams, reason } = /** @type {import("./grid.js").Stored} */ (begin.about.stored);
      const width = begin.arrays.x.length;
      const valuesAt = (/** @type {"x" | "y"} */ which, /** @type {number} */ at) =>
        Object.fromEntries(Object.entries(sets[which]).map(([name, values]) => [name, values[at]]));
      begin.optionsOf = (cell) => {
        if (!options) throw new InputError(reason);
        const [x, y] = [cell % width, Math.floor(cell / width)];
        const own = streams ? { noise_stream: streams.x[x] + streams.y[y] } : {};
        return optionsAt(registry, { ...options, ...own },
          { ...sets.all, ...valuesAt("x", x), ...valuesAt("y", y) });
      };
      listener.begin(begin);
      const count = arrays.status.length;
      this.count = count;
      const progress = { points: 0, seconds: 0, rate: 0 };
      listener.cells({ cell: Int32Array.from({ length: count }, (_, i) => i),
        stride: new Uint8Array(count).fill(1), status: Uint8Array.from(arrays.status, (each) => each),
        values: [arrays.values] }, progress);
      this.ended = true;
      listener.done(progress);
    } catch (error) {
      if (this.ended || (error instanceof DOMException && error.name === "AbortError")) return;
      this.ended = true;
      listener.refused(/** @type {Error} */ (error));
    }
  }

  start() {}

  /** Forget it. */
  cancel() {
    this.ended = true;
    this.control.abort();
  }
}
