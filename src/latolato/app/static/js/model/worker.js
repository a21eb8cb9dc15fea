/** Runs beside the page: each message is a request, each answer a block or what is wrong. */

import { answer } from "./answer.js";

self.addEventListener("message", async ({ data }) => {
  const result = await answer(data);
  const buffers = new Set(Object.values(result.block?.arrays ?? {}).map((array) => array.buffer));
  self.postMessage(result, { transfer: [...buffers] });
});
// Until it has spoken, a page may not know whether it is allowed to have workers.
self.postMessage(null);
