/** One map on its way from the server: the socket is the job, closing it ends the work. */

import { hangUp, socketAddress } from "../shared/api.js";
import { unpack } from "../shared/block.js";

/** @typedef {import("../shared/block.js").Block} Block */
/** @typedef {{choices: (choices: any) => void, phase: (name: string) => void,
 *   begin: (block: Block) => void, cells: (block: Block) => void, done: (block: Block) => void,
 *   refused: (text: string, field: string | null) => void, lost: () => void}} Listener */

export class MapJob {
  /**
   * @param {Record<string, any>} request
   * @param {Listener} listener
   */
  constructor(request, listener) {
    this.request = request;
    this.listener = listener;
    this.ended = false;
    this.socket = new WebSocket(socketAddress("ws/map"));
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("open", () => {
      if (!this.ended) this.socket.send(JSON.stringify(request));
    });
    this.socket.addEventListener("message", ({ data }) => this.take(data));
    this.socket.addEventListener("close", () => {
      if (this.ended) return;
      this.ended = true;
      listener.lost();
    });
  }

  /** @param {string | ArrayBuffer} data */
  take(data) {
    if (this.ended) return;
    if (typeof data === "string") {
      const told = JSON.parse(data);
      if (told.choices) this.listener.choices(told.choices);
      else if (told.phase) this.listener.phase(told.phase);
      else if (told.error) {
        this.ended = true;
        this.listener.refused(told.error, told.field ?? null);
      }
      return;
    }
    const block = unpack(data);
    const { kind } = block.about;
    if (kind === "done") this.ended = true;
    if (kind === "begin" || kind === "cells" || kind === "done") this.listener[
      /** @type {"begin" | "cells" | "done"} */ (kind)](block);
  }

  /** End the work; the server stops its kernels at once. */
  cancel() {
    this.ended = true;
    hangUp(this.socket);
  }
}
