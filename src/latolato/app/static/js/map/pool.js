/** Workers that compute one map at a time, from coarse to fine. */

import { loadKernels, loadLayout, loadModule } from "../kernels/load.js";
import { countSteps, moduleOf } from "../kernels/map.js";
import { inOrder, pointsOf } from "./plan.js";
import { t } from "../strings.js";

/**
 * @typedef {import("./plan.js").Plan} Plan
 * @typedef {{points: number, seconds: number, rate: number, share: number}} Progress points that are computed,
 *   in how long [s], how many in a second, and which share of all
 *
 * How a map is computed: with a `stride`, a power of two, only so many rows and columns; without the cells
 * that are known. Of cells that come `values` has the rows of `variablesOf`.
 * @typedef {{stride?: number, isKnown?: (cell: number) => boolean,
 *   onCells: (cells: import("./grid.js").Cells, progress: Progress) => void}} How
 *
 * @typedef {Awaited<ReturnType<Pool["estimate"]>>} Estimate
 * @typedef {{cell: Int32Array, stride: Uint8Array}} Batch
 * @typedef {Pick<Worker, "postMessage" | "terminate" | "addEventListener">} Thread
 * @typedef {{thread: Thread, module: string, batch: Batch | null}} Member
 * @typedef {import("./map_worker.js").WorkerStart} WorkerStart
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

/** @returns {Thread} */
const pageWorker = () => new Worker(new URL("./map_worker.js", import.meta.url), { type: "module" });

/** Cells of a map on their way. */
class Job {
  /**
   * @param {Plan} plan
   * @param {Estimate} estimate
   * @param {How} how
   * @param {(progress: Progress) => void} resolve
   * @param {(error: Error) => void} reject
   */
  constructor(plan, estimate, { stride: finest = 1, isKnown = () => false, onCells }, resolve, reject) {
    this.plan = plan;
    this.onCells = onCells;
    this.resolve = resolve;
    this.reject = reject;
    const { cells, strides } = inOrder(plan.x.values.length, plan.y.values.length);
    /** Steps of a point, and what kind they are. */
    this.steps = estimate.steps / cells.length;
    /** @type {keyof typeof USUAL_STEP} */
    this.kind = estimate.in_lanes ? "lanes" : "single";
    const fresh = [...cells.keys()].filter((k) => strides[k] >= finest && !isKnown(cells[k]));
    this.cells = Int32Array.from(fresh, (k) => cells[k]);
    this.strides = Uint8Array.from(fresh, (k) => strides[k]);
    this.next = 0;
    this.points = 0;
    this.begin = performance.now();
    /** The fewest cells of a batch. */
    this.least = 1;
    /** @type {WorkerStart | null} */
    this.start = null;
  }

  /** Return how far it is. @returns {Progress} */
  progress() {
    const seconds = (performance.now() - this.begin) / 1e3;
    return { points: this.points, seconds, rate: this.points / seconds, share: this.points / this.cells.length };
  }

  /**
   * Return the cells that are computed next, null if there are none.
   * @param {number} target how many would do
   * @param {number} workers
   * @returns {Batch | null}
   */
  take(target, workers) {
    const left = this.cells.length - this.next;
    if (!left) return null;
    const coarse = this.strides.lastIndexOf(this.strides[0]) + 1;
    // All workers share the first picture, and the last.
    const share = this.next < coarse ? Math.ceil(coarse / workers)
      : Math.max(this.least, Math.ceil(left / workers));
    const size = Math.min(left, share, Math.max(this.least, target));
    this.next += size;
    return { cell: this.cells.slice(this.next - size, this.next),
      stride: this.strides.slice(this.next - size, this.next) };
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
  }

  /**
   * Return how many steps a map and its longest point take, and whether points run in lanes; where no point
   * can run, the problem of the first.
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
    return { steps: total, longest: Math.max(0, ...valid), in_lanes, problem: valid.length ? null : problem };
  }

  /**
   * Compute a map, instead of the one before; an AbortError ends one that is stopped.
   * @param {Plan} plan
   * @param {Estimate} estimate
   * @param {How} how
   * @returns {Promise<Progress>}
   */
  compute(plan, estimate, how) {
    this.stop();
    return new Promise((resolve, reject) => {
      const job = this.job = new Job(plan, estimate, how, resolve, reject);
      this.begin(job).catch((error) => this.fail(job, error));
    });
  }

  /** @param {Job} job */
  async begin(job) {
    const start = await workerStart(moduleOf(job.plan));
    if (job !== this.job) return;
    job.start = start;
    if (job.kind === "lanes") job.least = FILLS * start.layout.lanes.lanes;
    this.members = this.members.filter((member) => {
      if (member.module !== start.name) member.thread.terminate();
      return member.module === start.name;
    });
    if (job.cells.length) this.employ(job);
    else this.finish(job);
  }

  /** End what is computed. Workers that are busy end; they are replaced when the next map starts. */
  stop() {
    this.job?.reject(new DOMException("", "AbortError"));
    this.job = null;
    this.members = this.members.filter((member) => {
      if (member.batch) member.thread.terminate();
      return !member.batch;
    });
  }

  /** End all workers. */
  close() {
    this.stop();
    for (const { thread } of this.members) thread.terminate();
    this.members = [];
  }

  /**
   * Begin workers that wait for a map.
   * @param {string} name of their module
   */
  async warm(name) {
    const start = await workerStart(name);
    if (!this.job) this.fill(start);
  }

  /** Begin as many workers as there are to be. @param {WorkerStart} start */
  fill(start) {
    while (this.members.length < this.size) this.members.push(this.member(start));
  }

  /** Let all workers that wait compute a map, with new ones in the places of those that ended. @param {Job} job */
  employ(job) {
    this.fill(/** @type {WorkerStart} */ (job.start));
    for (const member of this.members) if (!member.batch) this.feed(member, job);
  }

  /**
   * Return a new worker.
   * @param {WorkerStart} start
   * @returns {Member}
   */
  member(start) {
    /** @type {Member} */
    const member = { thread: this.makeWorker(), module: start.name, batch: null };
    member.thread.addEventListener("message", ({ data }) => this.receive(member, data));
    member.thread.addEventListener("error", (event) =>
      this.lose(member, /** @type {ErrorEvent} */ (event).message));
    member.thread.postMessage({ start });
    return member;
  }

  /**
   * Send a worker its next cells, as many as take as long as a batch should.
   * @param {Member} member
   * @param {Job} job
   */
  feed(member, job) {
    const size = Math.round(BATCH / (job.steps * this.step[job.kind]));
    member.batch = job.take(Math.max(1, Math.min(LARGEST_BATCH, size)), this.size);
    if (member.batch) member.thread.postMessage({ plan: job.plan, cells: member.batch.cell });
  }

  /**
   * Take in what a worker has computed.
   * @param {Member} member
   * @param {any} data
   */
  receive(member, data) {
    const { batch } = member;
    const { job } = this;
    if (data.death) {
      this.lose(member, data.death);
      return;
    }
    // A worker that was ended while it was busy may still say something.
    if (!job || !batch || !this.members.includes(member)) return;
    member.batch = null;
    if (data.error) {
      this.fail(job, new Error(data.error));
      return;
    }
    const { cell, stride } = batch;
    job.points += cell.length;
    // Small batches leave lanes empty: they say nothing of large ones.
    if (cell.length >= job.least) this.step[job.kind] = data.seconds / (cell.length * job.steps);
    this.feed(member, job);
    job.onCells({ cell, stride, status: data.status, values: data.values }, job.progress());
    if (job === this.job && job.points === job.cells.length) this.finish(job);
  }

  /** Tell that a map is complete. @param {Job} job */
  finish(job) {
    this.job = null;
    job.resolve(job.progress());
  }

  /**
   * Give up a worker that has died, and the map of which it computed a part: what is known of that stays.
   * @param {Member} member
   * @param {string} message
   */
  lose(member, message) {
    if (!this.members.includes(member)) return;
    member.thread.terminate();
    this.members = this.members.filter((each) => each !== member);
    if (this.job && member.batch) this.fail(this.job, new Error(t("refuseSome", { error: message })));
  }

  /**
   * Tell what is wrong with a map, and end it.
   * @param {Job} job
   * @param {Error} error
   */
  fail(job, error) {
    if (job !== this.job) return;
    job.reject(error);
    this.stop();
  }
}

/**
 * Return what a worker begins with.
 * @param {string} name of its module
 * @returns {Promise<WorkerStart>}
 */
async function workerStart(name) {
  const [layout, module] = await Promise.all([loadLayout(), loadModule(name)]);
  return { name, layout, module };
}
