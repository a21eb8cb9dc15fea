/** Workers that compute one map at a time, from coarse to fine. */

import { loadKernels, loadLayout, loadModule } from "../kernels/load.js";
import { countSteps, moduleOf } from "../kernels/map.js";
import { cellsOf, Memory, pointsAt, put } from "./known.js";
import { inOrder, pointsOf, variablesOf } from "./plan.js";
import { t } from "../strings.js";

/**
 * @typedef {import("./plan.js").Plan} Plan
 * @typedef {{points: number, seconds: number, rate: number}} Progress points that are computed, in
 *   how long [s], and how many in a second
 *
 * What becomes of a map: cells as they come, row after row of `variablesOf`, those first that other
 * maps have had; then its end, or what is wrong with it. A worker that dies is replaced, and
 * computes its cells again.
 * @typedef {object} PoolListener
 * @property {(cells: {cell: Int32Array, stride: Uint8Array, status: Uint8Array,
 *   values: Float64Array[]}, progress: Progress) => void} onCells
 * @property {(progress: Progress) => void} onDone
 * @property {(error: Error) => void} onError
 * @property {(message: string) => void} [onRestart]
 *
 * @typedef {Awaited<ReturnType<Pool["estimate"]>>} Estimate
 * @typedef {{cell: Int32Array, stride: Uint8Array, tries: number}} Batch
 * @typedef {Pick<Worker, "postMessage" | "terminate" | "addEventListener">} Thread
 * @typedef {{thread: Thread, module: string, batch: Batch | null, job: Job | null}} Member
 */

// A batch takes about so long [s]: on two cores a picture comes at least as often. Smaller ones leave
// lanes empty: a point takes 0.55 ms in batches of 600, 0.88 ms in batches of 128.
const BATCH = 0.35;
const LARGEST_BATCH = 4096;
// Batches in lanes have so many cells for each: a lane whose point has ended takes up the next one.
// With one cell for each lane, a map takes 1.6 times as long; with all in one batch, 8 % less.
const FILLS = 2;
// Cells along each axis whose steps are counted before a map begins.
const PROBES = 7;
// A step in lanes, and one of a single trajectory, until they are measured [s].
const USUAL_STEP = { lanes: 1.5e-7, single: 5e-7 };
// A batch that ends so many workers is given up.
const TRIES = 2;

/** @returns {Thread} */
const pageWorker = () => new Worker(new URL("./map_worker.js", import.meta.url), { type: "module" });

/** Cells of a map on their way. */
class Job {
  /**
   * @param {Plan} plan
   * @param {PoolListener} listener
   * @param {number} stride of the rows and columns to compute
   */
  constructor(plan, listener, stride) {
    this.plan = plan;
    this.listener = listener;
    const { cells, strides } = inOrder(plan.x.values.length, plan.y.values.length);
    this.count = cells.length;
    // Strides fall.
    const end = strides.findLastIndex((each) => each >= stride) + 1;
    this.cells = cells.slice(0, end);
    this.strides = strides.slice(0, end);
    this.next = 0;
    /** @type {import("./known.js").Known | null} */
    this.known = null;
    /** @type {Batch[]} */
    this.again = [];
    this.points = 0;
    this.begin = performance.now();
    /** @type {Pick<Estimate, "steps" | "in_lanes">} */
    this.estimate = { steps: NaN, in_lanes: false };
    /** @type {import("./map_worker.js").WorkerStart | null} */
    this.start = null;
    this.least = 1;
  }

  /**
   * Show the cells that are known, which need not be computed.
   * @param {import("./known.js").Known} known
   */
  begins(known) {
    this.known = known;
    if (!cellsOf(known).length) return;
    const isKnown = new Set(cellsOf(known));
    const [old, fresh] = [true, false].map((wanted) =>
      [...this.cells.keys()].filter((k) => isKnown.has(this.cells[k]) === wanted));
    const cell = Int32Array.from(old, (k) => this.cells[k]);
    const stride = Uint8Array.from(old, (k) => this.strides[k]);
    this.cells = Int32Array.from(fresh, (k) => this.cells[k]);
    this.strides = Uint8Array.from(fresh, (k) => this.strides[k]);
    this.listener.onCells({ cell, stride, ...pointsAt(known, cell) }, this.progress());
  }

  /** Return how far it is. @returns {Progress} */
  progress() {
    const seconds = (performance.now() - this.begin) / 1e3;
    return { points: this.points, seconds, rate: this.points / seconds };
  }

  /**
   * Return the cells that are computed next, null if there are none.
   * @param {number} target how many would do
   * @param {number} workers
   * @returns {Batch | null}
   */
  take(target, workers) {
    const batch = this.again.pop();
    if (batch) return batch;
    const left = this.cells.length - this.next;
    if (!left) return null;
    const coarse = this.strides.lastIndexOf(this.strides[0]) + 1;
    // All workers share the first picture, and the last.
    const share = this.next < coarse ? Math.ceil(coarse / workers)
      : Math.max(this.least, Math.ceil(left / workers));
    const size = Math.min(left, share, Math.max(this.least, target));
    this.next += size;
    return { cell: this.cells.slice(this.next - size, this.next),
      stride: this.strides.slice(this.next - size, this.next), tries: 0 };
  }
}

export class Pool {
  /**
   * @param {number} [size] how many workers, one for each core if it is left out
   * @param {() => Thread} [makeWorker]
   */
  constructor(size = navigator.hardwareConcurrency, makeWorker = pageWorker) {
    this.size = size;
    this.makeWorker = makeWorker;
    /** @type {Member[]} */
    this.members = [];
    /** @type {Job | null} */
    this.job = null;
    this.step = { ...USUAL_STEP };
    this.memory = new Memory();
  }

  /**
   * Return how many steps a map and its longest point take, and about how long that is with all
   * workers [s]; where no point can run, the problem of the first.
   * @param {Plan} plan
   */
  async estimate(plan) {
    const kernels = await loadKernels(moduleOf(plan));
    const [width, height] = [plan.x.values.length, plan.y.values.length];
    const places = (/** @type {number} */ size) => [...new Set(Array.from({ length: PROBES },
      (_, i) => Math.round((i * (size - 1)) / (PROBES - 1))))];
    const cells = places(height).flatMap((row) => places(width).map((column) => row * width + column));
    const { steps, problem, in_lanes } = countSteps(kernels, pointsOf(kernels.layout, plan, cells));
    const valid = steps.filter((each) => !Number.isNaN(each));
    const total = (valid.reduce((sum, each) => sum + each, 0) / steps.length) * width * height;
    const seconds = (total * this.step[in_lanes ? "lanes" : "single"]) / this.size;
    return { steps: total, longest: Math.max(0, ...valid), seconds, in_lanes,
      problem: valid.length ? null : problem };
  }

  /**
   * Compute a map; what was computed before ends at once.
   * @param {Plan} plan
   * @param {PoolListener} listener
   * @param {Promise<Estimate> | Estimate} [known]
   * @param {number} [stride] of the rows and columns to compute, a power of two
   */
  async start(plan, listener, known = this.estimate(plan), stride = 1) {
    this.stop();
    const job = new Job(plan, listener, stride);
    this.job = job;
    try {
      const name = moduleOf(plan);
      const [estimate, layout, module] = await Promise.all([
        known, loadLayout(), loadModule(name)]);
      if (job !== this.job) return;
      if (estimate.problem) throw new Error(t("refusePoints"));
      job.estimate = estimate;
      job.start = { module, name, layout };
      if (estimate.in_lanes) job.least = FILLS * layout.lanes.lanes;
      this.members = this.members.filter((member) => {
        if (member.module !== name) member.thread.terminate();
        return member.module === name;
      });
      job.begins(this.memory.begin(plan, variablesOf(layout, plan).length));
      if (job !== this.job) return; // stopped by who saw these
      if (job.cells.length) this.employ(job);
      else this.finish(job);
    } catch (error) {
      this.fail(job, /** @type {Error} */ (error));
    }
  }

  /** End what is computed. Workers that are busy end; they are replaced when the next map starts. */
  stop() {
    this.job = null;
    this.members = this.members.filter((member) => {
      if (member.batch) member.thread.terminate();
      return !member.batch;
    });
  }

  /** End all workers. */
  close() {
    this.job = null;
    for (const { thread } of this.members) thread.terminate();
    this.members = [];
  }

  /**
   * Begin workers that wait for a map.
   * @param {string} name of their module
   */
  async warm(name) {
    const [layout, module] = await Promise.all([loadLayout(), loadModule(name)]);
    if (!this.job) this.fill({ layout, module, name });
  }

  /** Begin as many workers as there are to be. @param {import("./map_worker.js").WorkerStart} start */
  fill(start) {
    while (this.members.length < this.size) this.members.push(this.member(start));
  }

  /** Let all workers compute a map, with new ones in the places of those that ended. @param {Job} job */
  employ(job) {
    this.fill(/** @type {import("./map_worker.js").WorkerStart} */ (job.start));
    for (const member of this.members) {
      if (member.job === job) continue;
      member.job = job;
      member.thread.postMessage({ plan: job.plan });
      this.feed(member);
    }
  }

  /**
   * Return a new worker.
   * @param {import("./map_worker.js").WorkerStart} start
   * @returns {Member}
   */
  member(start) {
    /** @type {Member} */
    const member = { thread: this.makeWorker(), module: start.name, batch: null, job: null };
    member.thread.addEventListener("message", ({ data }) => this.receive(member, data));
    member.thread.addEventListener("error", (event) =>
      this.replace(member, /** @type {ErrorEvent} */ (event).message));
    member.thread.postMessage({ start });
    return member;
  }

  /** Send a worker its next cells. @param {Member} member */
  feed(member) {
    const { job } = this;
    if (!job || member.job !== job) return;
    member.batch = job.take(this.target(job), this.size);
    if (member.batch) member.thread.postMessage({ cells: member.batch.cell });
  }

  /** Return how many cells of a map take as long as a batch should. @param {Job} job */
  target(job) {
    const { in_lanes, steps } = job.estimate;
    const point = (steps / job.count) * this.step[in_lanes ? "lanes" : "single"];
    return Math.max(1, Math.min(LARGEST_BATCH, Math.round(BATCH / point)));
  }

  /**
   * Take in what a worker has computed.
   * @param {Member} member
   * @param {any} data
   */
  receive(member, data) {
    const { batch, job } = member;
    if (data.death) {
      this.replace(member, data.death);
      return;
    }
    member.batch = null;
    if (!job || job !== this.job || !batch) return;
    if (data.error) {
      this.fail(job, new Error(data.error));
      return;
    }
    const { in_lanes, steps } = job.estimate;
    job.points += batch.cell.length;
    // Small batches leave lanes empty: they say nothing of large ones.
    if (batch.cell.length >= job.least)
      this.step[in_lanes ? "lanes" : "single"] =
        data.seconds / (batch.cell.length * (steps / job.count));
    if (job.known) put(job.known, batch.cell, data);
    this.feed(member);
    const progress = job.progress();
    const { cell, stride } = batch;
    job.listener.onCells({ cell, stride, status: data.status, values: data.values }, progress);
    if (job === this.job && job.points === job.cells.length) this.finish(job);
  }

  /** Tell that a map is complete. @param {Job} job */
  finish(job) {
    this.job = null;
    job.listener.onDone(job.progress());
  }

  /**
   * Put a new worker in the place of one that has died, which computes the same cells again.
   * @param {Member} member
   * @param {string} message
   */
  replace(member, message) {
    if (!this.members.includes(member)) return;
    member.thread.terminate();
    this.members = this.members.filter((each) => each !== member);
    const { job, batch } = member;
    if (!job || job !== this.job || !batch) return;
    batch.tries += 1;
    if (batch.tries >= TRIES) {
      this.fail(job, new Error(t("refuseSome", { error: message })));
      return;
    }
    job.again.push(batch);
    job.listener.onRestart?.(message);
    this.employ(job);
  }

  /**
   * Tell what is wrong with a map, and end it.
   * @param {Job} job
   * @param {Error} error
   */
  fail(job, error) {
    if (job !== this.job) return;
    this.stop();
    job.listener.onError(error);
  }
}
