/** The files of this site; a notebook's program has a module in this place that holds them. */

const ROOT = new URL("../../", import.meta.url);

/**
 * Return the content of a file, also where no server has it: in Node.js.
 * @param {string} path such as "kernels/one.wasm"
 */
export async function contentOf(path) {
  const address = new URL(path, ROOT);
  if (address.protocol !== "file:") {
    const response = await fetch(address);
    if (!response.ok) throw new Error(`${address} cannot be loaded: ${response.status}`);
    return response;
  }
  const { readFile } = await import(/** @type {any} */ ("node:fs/promises"));
  return new Response(await readFile(address));
}
