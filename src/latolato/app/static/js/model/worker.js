/** Begins workers that compute runs. It imports nothing, so that a page can begin one before it has loaded. */

/**
 * Return a worker that loads what it computes with, null where the page's policy or the browser refuses it.
 * `begins` ends when it answers, with an error if it cannot be loaded.
 * @returns {{worker: Worker, begins: Promise<Event>} | null}
 */
export function beginWorker() {
  let worker;
  try {
    worker = new Worker(new URL("./run_worker.js", import.meta.url), { type: "module" });
  } catch {
    return null;
  }
  const begins = new Promise((resolve, reject) => {
    worker.addEventListener("message", resolve, { once: true });
    worker.addEventListener("error", reject, { once: true });
  });
  begins.catch(() => {}); // said to who asks
  return { worker, begins };
}
