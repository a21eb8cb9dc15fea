/** The page's place on the server for its videos and tables: uploads, jobs, and files. */

import { Refusal, socketAddress } from "../page/api.js";
import { doJob } from "../page/jobs.js";
import { t } from "../strings.js";

const AGAIN = 2000; // ms

/**
 * @typedef {{notify: (status: import("../page/jobs.js").Status) => void, signal: AbortSignal}} Follow
 * @typedef {{kind: string, title: string, headline: string[], hint: string, is_slow: boolean,
 *   fewest_balls: number}} FitKind
 * @typedef {{desk: string, fields: Record<string, any>, fits: FitKind[], examples: string[],
 *   limits: {upload: number, duration: number, pixels: number},
 *   template: {round: number, share: number},
 *   tables: {endings: string[], roles: Record<string, string[]>}}} Hello
 */

export class Desk {
  /** @param {(open: boolean) => void} changed called when the connection comes or goes */
  constructor(changed) {
    this.changed = changed;
    /** @type {Hello | null} */
    this.hello = null;
    /** @type {WebSocket | null} */
    this.socket = null;
    /** How often a connection was made: clips of an earlier one are gone. */
    this.epoch = 0;
    this.connect();
  }

  connect() {
    const socket = new WebSocket(socketAddress("ws/experiment/desk"));
    this.socket = socket;
    socket.addEventListener("message", ({ data }) => {
      this.hello = JSON.parse(data);
      this.epoch += 1;
      this.changed(true);
    });
    socket.addEventListener("close", () => {
      this.hello = null;
      this.changed(false);
      setTimeout(() => this.connect(), AGAIN);
    });
  }

  /**
   * Return the block that work on a clip ends with.
   * @param {Record<string, any>} request
   * @param {Follow} follow
   */
  job(request, follow) {
    return doJob("ws/experiment", request, follow);
  }

  /**
   * Upload a file; return the key of the clip.
   * @param {File} file
   * @param {Follow} follow
   * @returns {Promise<string>}
   */
  upload(file, { notify, signal }) {
    const { hello } = this;
    return new Promise((resolve, reject) => {
      if (!hello) throw new Refusal(t("offline"));
      const limit = hello.limits.upload;
      if (file.size > limit)
        throw new Refusal(t("uploadTooLarge", { name: file.name, limit: limit / 1e6 }));
      const request = new XMLHttpRequest();
      signal.addEventListener("abort", () => request.abort());
      request.open("POST", `api/experiment?desk=${encodeURIComponent(hello.desk)}`);
      request.setRequestHeader("X-Name", encodeURIComponent(file.name));
      request.responseType = "json";
      const show = (/** @type {number} */ progress) =>
        notify({ state: "uploading", progress, elapsed: 0 });
      request.upload.addEventListener("progress", (e) => show(e.loaded / e.total));
      request.addEventListener("abort", () => reject(new DOMException("", "AbortError")));
      request.addEventListener("error", () => reject(new Refusal(t("offline"))));
      request.addEventListener("load", () => {
        if (request.status === 200) resolve(request.response.clip);
        else reject(new Refusal(request.response?.error ?? t("offline"), null, request.response?.parts));
      });
      show(0);
      request.send(file);
    });
  }
}

/**
 * Return the address of a file of a clip.
 * @param {string} clip
 * @param {string} file
 */
export function clipAddress(clip, file) {
  return `api/experiment/${encodeURIComponent(clip)}/${file}`;
}

/**
 * Return an address in this page of a file of a clip, which stays when the server forgets it.
 * @param {string} clip
 * @param {string} file
 */
export async function clipCopy(clip, file) {
  const response = await fetch(clipAddress(clip, file));
  if (!response.ok) throw new Refusal(t("clipsLost"));
  return URL.createObjectURL(await response.blob());
}
