/** Runs beside the page: each message is a request, each answer a block or what is wrong. */

import { answer } from "./answer.js";
import { loadRegistry } from "./registry.js";

self.addEventListener("message", async ({ data }) => {
  const result = await answer(data);
  const buffers = new Set(Object.values(result.block?.arrays ?? {}).map((array) => array.buffer));
  self.postMessage(result, { transfer: [...buffers] });
});
// Until then a page does not know whether it may have workers.
void loadRegistry().then(() => self.postMessage(null));
