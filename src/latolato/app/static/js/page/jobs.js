/** Long work on the server: how far it is, how it is cancelled, and what comes of it. */

import { languageCode, t } from "../strings.js";
import { hangUp, Refusal, socketAddress } from "./api.js";
import { unpack } from "./block.js";
import { el, notify } from "./dom.js";
import { sentenceOfError } from "./refusals.js";

/** @typedef {{state: string, elapsed: number, progress?: number}} Status */
/** @typedef {import("./block.js").Block} Block */

// Work that waits for other work says so after this time.
const PATIENCE = 1; // s

/**
 * Return the block that a job ends with, presented in the language of the page; a Refusal is thrown where the server gives a reason, and
 * an AbortError where the signal ends the job.
 * @param {string} path
 * @param {any} request
 * @param {{notify?: (status: Status) => void, signal?: AbortSignal}} [options]
 * @returns {Promise<Block>}
 */
export function doJob(path, request, { notify, signal } = {}) {
  return new Promise((resolve, reject) => {
    if (signal?.aborted) {
      reject(new DOMException("", "AbortError"));
      return;
    }
    const socket = new WebSocket(socketAddress(path));
    socket.binaryType = "arraybuffer";
    const abort = () => {
      reject(new DOMException("", "AbortError"));
      hangUp(socket);
    };
    signal?.addEventListener("abort", abort, { once: true });
    socket.addEventListener("open", () => {
      if (!signal?.aborted) socket.send(JSON.stringify({ ...request, language: languageCode() }));
    });
    socket.addEventListener("message", ({ data }) => {
      if (data instanceof ArrayBuffer) resolve(unpack(data));
      else {
        const message = JSON.parse(data);
        if ("error" in message) reject(new Refusal(message.error, message.field, message.parts));
        else notify?.(message);
      }
    });
    socket.addEventListener("close", ({ reason }) => {
      signal?.removeEventListener("abort", abort);
      reject(new Refusal(reason || t("offline")));
    });
  });
}

/**
 * Return how far a job is, in words.
 * @param {Status} status
 * @returns {string}
 */
export function statusText({ state: reported, elapsed, progress }) {
  // Nothing has to finish before work that begins at once.
  const state = reported === "waiting" && elapsed < PATIENCE ? "working" : reported;
  const seconds = elapsed.toFixed(elapsed < 10 ? 1 : 0);
  if (state !== "working" || progress === undefined) return t(`job_${state}`, { seconds });
  return t("job_progress", { percent: Math.round(100 * progress), seconds });
}

/** A line that shows how far a job is, with a button that cancels it. */
export class JobLine {
  constructor() {
    /** @type {AbortController | null} */
    this.running = null;
    this.bar = el("progress", { max: "1", "aria-label": t("job_bar") });
    this.text = el("span", { class: "soft", role: "status" });
    this.cancel = el("button", { type: "button", on: { click: () => this.stop() } },
      t("cancel"));
    this.error = el("p", { class: "error", role: "alert", hidden: true });
    /** Why the last job gave nothing. @type {Refusal | null} */
    this.refusal = null;
    this.line = el("div", { class: "row job", hidden: true }, this.bar, this.text, this.cancel);
    this.root = el("div", {}, this.line, this.error);
  }

  /**
   * The result of a job, null if it is refused (which is shown) or cancelled.
   * @param {string} path
   * @param {any} request
   * @returns {Promise<Block | null>}
   */
  async run(path, request) {
    this.running?.abort();
    const own = this.running = new AbortController();
    this.clear();
    this.line.hidden = false;
    this.line.dataset.status = "";
    this.show({ state: "waiting", elapsed: 0 });
    try {
      return await doJob(path, request, { signal: own.signal, notify: (status) => {
        if (this.running === own) this.show(status);
      } });
    } catch (error) {
      if (error instanceof Refusal) {
        this.refusal = error;
        this.refuse(sentenceOfError(error.input ?? error));
      }
      else if (!(error instanceof DOMException)) throw error;
      return null;
    } finally {
      if (this.running === own) {
        this.running = null;
        this.line.hidden = true;
      }
    }
  }

  /** Whether a job runs that nobody cancelled. */
  get isRunning() {
    return this.running !== null && !this.running.signal.aborted;
  }

  /** Show nothing. */
  clear() {
    this.line.hidden = true;
    this.error.hidden = true;
    this.refusal = null;
  }

  /** @param {string} text */
  refuse(text) {
    this.error.textContent = text;
    this.error.hidden = false;
  }

  /** @param {Status} status */
  show(status) {
    const { state, elapsed, progress } = status;
    if (progress === undefined || state !== "working") this.bar.removeAttribute("value");
    else this.bar.value = progress;
    // Not at every frame: screen readers read each change.
    const second = `${state}${Math.floor(elapsed)}`;
    if (second === this.line.dataset.status) return;
    this.line.dataset.status = second;
    this.text.textContent = statusText(status);
  }

  /** Cancel what runs. */
  stop() {
    this.running?.abort();
  }
}

/** Makes the files that somebody asks for, one after the other. */
export class FileQueue {
  constructor() {
    this.job = new JobLine();
    /** How many are being made or wait. */
    this.count = 0;
    /** Ends when all of them are made. */
    this.all = Promise.resolve();
    /** Which of those that wait are still wanted. */
    this.wanted = new AbortController();
  }

  /**
   * Make a file as soon as those before it are made or cancelled.
   * @param {string} name of the file in a sentence
   * @param {() => Promise<void>} make
   */
  add(name, make) {
    const { signal } = this.wanted;
    if (this.count > 0) notify(t("fileWaits", { name }));
    this.count += 1;
    const done = this.all.then(() => (signal.aborted ? undefined : make())).finally(() => { this.count -= 1; });
    // A file that fails leaves the others to be made.
    this.all = done.catch(() => {});
    return done;
  }

  /** Cancel what is being made, and what waits. */
  stop() {
    this.wanted.abort();
    this.wanted = new AbortController();
    this.job.stop();
  }
}

/**
 * Return a file of a block.
 * @param {Block} block
 * @param {string} name of the array that holds its bytes
 * @param {string} type
 * @returns {Blob}
 */
export function fileOf(block, name, type) {
  return new Blob([/** @type {Uint8Array<ArrayBuffer>} */ (block.arrays[name])], { type });
}
