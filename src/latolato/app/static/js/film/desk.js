/** The page's place on the server for its videos: uploads, jobs with progress, and results. */

import { Refusal, socketAddress } from "../api.js";
import { unpack } from "../block.js";
import { t } from "../strings.js";

const AGAIN = 2000; // ms

/**
 * @typedef {(stage: string, share: number) => void} Tell
 * @typedef {{kind: string, title: string, headline: string[], hint: string, is_slow: boolean,
 *   fewest_balls: number}} FitKind
 * @typedef {{desk: string, fields: Record<string, any>, fits: FitKind[], examples: string[],
 *   limits: {upload: number, duration: number, pixels: number}}} Hello
 * @typedef {{promise: Promise<any>, cancel: () => void}} Job
 */

export class Desk {
  /** @param {(open: boolean) => void} changed called when the connection comes or goes */
  constructor(changed) {
    this.changed = changed;
    /** @type {Hello | null} */
    this.hello = null;
    /** @type {WebSocket | null} */
    this.socket = null;
    this.count = 0;
    /** How often a connection was made: films of an earlier one are gone. */
    this.epoch = 0;
    /** @type {Map<number, {tell: Tell, done: (result: any) => void, fail: (e: Error) => void}>} */
    this.jobs = new Map();
    this.connect();
  }

  connect() {
    const socket = new WebSocket(socketAddress("api/films/desk"));
    this.socket = socket;
    // The server closes a socket that sends nothing.
    socket.addEventListener("open", () => socket.send(JSON.stringify({ hello: true })));
    socket.addEventListener("message", (event) => this.hear(JSON.parse(event.data)));
    socket.addEventListener("close", () => {
      this.hello = null;
      for (const job of this.jobs.values()) job.fail(new Refusal(t("filmsLost")));
      this.jobs.clear();
      this.changed(false);
      setTimeout(() => this.connect(), AGAIN);
    });
  }

  /** @param {any} message */
  hear(message) {
    if (message.desk) {
      this.hello = message;
      this.epoch += 1;
      this.changed(true);
      return;
    }
    const job = this.jobs.get(message.job);
    if (!job) return;
    if ("stage" in message) {
      job.tell(message.stage, message.progress);
      return;
    }
    this.jobs.delete(message.job);
    if (message.cancelled) job.fail(new DOMException("", "AbortError"));
    else if ("error" in message) job.fail(new Refusal(message.error, message.field));
    else job.done(message.done);
  }

  /**
   * Return a job that the server works on; its promise fails with a Refusal, or an AbortError.
   * @param {Record<string, any>} what
   * @param {Tell} [tell]
   * @returns {Job}
   */
  job(what, tell = () => {}) {
    this.count += 1;
    const job = this.count;
    const send = (/** @type {any} */ message) => this.socket?.send(JSON.stringify(message));
    const promise = new Promise((done, fail) => {
      if (!this.hello) {
        fail(new Refusal(t("offline")));
        return;
      }
      this.jobs.set(job, { tell, done, fail });
      send({ ...what, job });
    });
    return { promise, cancel: () => { if (this.jobs.has(job)) send({ do: "cancel", job }); } };
  }

  /**
   * Return an upload; its promise gives the key of the film.
   * @param {File} file
   * @param {Tell} tell
   * @returns {Job}
   */
  upload(file, tell) {
    const request = new XMLHttpRequest();
    const promise = new Promise((done, fail) => {
      if (!this.hello) {
        fail(new Refusal(t("offline")));
        return;
      }
      if (file.size > this.hello.limits.upload) {
        fail(new Refusal(t("uploadTooLarge", { name: file.name,
          limit: this.hello.limits.upload / 1e6 })));
        return;
      }
      request.open("POST", `api/films?desk=${encodeURIComponent(this.hello.desk)}`);
      request.setRequestHeader("X-Name", encodeURIComponent(file.name));
      request.responseType = "json";
      request.upload.addEventListener("progress", (e) => tell("uploading", e.loaded / e.total));
      request.addEventListener("abort", () => fail(new DOMException("", "AbortError")));
      request.addEventListener("error", () => fail(new Refusal(t("offline"))));
      request.addEventListener("load", () => {
        if (request.status === 200) done(request.response);
        else fail(new Refusal(request.response?.error ?? t("offline")));
      });
      tell("uploading", 0);
      request.send(file);
    });
    return { promise, cancel: () => request.abort() };
  }
}

/**
 * Return the address of a file of a film.
 * @param {string} film
 * @param {string} file
 */
export function filmAddress(film, file) {
  return `api/films/${encodeURIComponent(film)}/${file}`;
}

/**
 * Return a file of a film as a block of arrays.
 * @param {string} film
 * @param {string} file
 */
export async function filmBlock(film, file) {
  const response = await fetch(filmAddress(film, file));
  if (!response.ok) throw new Refusal(t("filmsLost"));
  return unpack(await response.arrayBuffer());
}

/**
 * Return an address in this page of a file of a film, which stays when the server forgets it.
 * @param {string} film
 * @param {string} file
 */
export async function filmCopy(film, file) {
  const response = await fetch(filmAddress(film, file));
  if (!response.ok) throw new Refusal(t("filmsLost"));
  return URL.createObjectURL(await response.blob());
}
