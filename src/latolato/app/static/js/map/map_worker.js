/** A worker that computes cells of a map, as many as it is sent. */

import { computeMap } from "../kernels/map.js";
import { Kernels } from "../kernels/memory.js";
import { pointsOf, variablesOf } from "./plan.js";

/**
 * First comes the module, then cells of a map.
 * @typedef {{module: WebAssembly.Module, name: string, layout: import("../kernels/memory.js").Layout}
 *   } WorkerStart
 * @typedef {{start?: WorkerStart, plan?: import("./plan.js").Plan, cells?: Int32Array}} Message
 */

/** @type {Promise<Kernels>} */
let kernels;
self.addEventListener("message", async ({ data }) => {
  const { start, plan, cells } = /** @type {Message} */ (data);
  if (start) kernels = Kernels.start(start.module, start.name, start.layout);
  if (!plan || !cells) return;
  try {
    const ready = await kernels;
    const begin = performance.now();
    const { layout } = ready;
    const { status, values } = computeMap(ready, pointsOf(layout, plan, cells));
    const rows = variablesOf(layout, plan).map(({ name, ball }) => {
      const step = values[name].length / cells.length;
      const first = ball ? step / 2 : 0;
      return Float64Array.from(cells, (_, k) => values[name][k * step + first]);
    });
    const result = { status, values: rows, seconds: (performance.now() - begin) / 1e3 };
    self.postMessage(result, { transfer: [status.buffer, ...rows.map(({ buffer }) => buffer)] });
  } catch (error) {
    // After a trap nothing is known of the memory: this worker must end.
    const name = error instanceof WebAssembly.RuntimeError ? "death" : "error";
    self.postMessage({ [name]: /** @type {Error} */ (error).message });
  }
});
