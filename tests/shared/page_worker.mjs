// Web Workers in Node.js: `PageWorker` runs the module of a page's worker in a thread.
import { fileURLToPath } from "node:url";
import { isMainThread, parentPort, Worker, workerData } from "node:worker_threads";

export class PageWorker {
  /** @param {string | URL} module */
  constructor(module) {
    this.worker = new Worker(fileURLToPath(import.meta.url), { workerData: { module: `${module}` } });
  }

  postMessage(data) {
    this.worker.postMessage(data);
  }

  addEventListener(name, listener) {
    this.worker.on(name, (value) => listener(name === "message" ? { data: value } : value));
  }

  terminate() {
    this.worker.terminate();
  }
}

if (!isMainThread && workerData?.module) {
  // Messages wait until the module listens.
  globalThis.self = Object.assign(new EventTarget(), {
    postMessage: (data, { transfer = [] } = {}) => parentPort.postMessage(data, transfer),
  });
  await import(workerData.module);
  parentPort.on("message", (data) => self.dispatchEvent(Object.assign(new Event("message"), { data })));
}
