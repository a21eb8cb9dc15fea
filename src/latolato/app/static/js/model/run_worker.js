/** Runs beside the page: each message is a question, see `answer.js`. */

import { loadAhead } from "../kernels/load.js";
import { answer } from "./reply.js";
import { loadRegistry } from "./registry.js";

self.addEventListener("message", async ({ data }) => {
  const result = await answer(data);
  const buffers = new Set(Object.values(result.block?.arrays ?? {}).map((array) => array.buffer));
  self.postMessage(result, { transfer: [...buffers] });
});
loadAhead();
// Until then a page does not know whether it may have workers.
void loadRegistry().then(() => self.postMessage(null));
