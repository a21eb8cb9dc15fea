/** Compiled modules from their files, in a page, in a worker and in Node.js. */

import { Kernels } from "./memory.js";

/** @typedef {import("./memory.js").Layout} Layout */

const FOLDER = new URL("../../kernels/", import.meta.url);
/** @type {Map<string, Promise<any>>} */
const loaded = new Map();
// A module of one function that needs simd128: it counts the bits of each byte of a vector.
const SIMD = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10,
  1, 8, 0, 65, 0, 253, 15, 253, 98, 11]);

/**
 * Return what is loaded once; after an error it is tried again.
 * @template T
 * @param {string} name
 * @param {() => Promise<T>} load
 * @returns {Promise<T>}
 */
function once(name, load) {
  const result = loaded.get(name) ?? load().catch((error) => {
    loaded.delete(name);
    throw error;
  });
  loaded.set(name, result);
  return result;
}

/**
 * Return the content of a file, also where no server has it: in Node.js.
 * @param {URL} address
 */
async function contentOf(address) {
  if (address.protocol !== "file:") {
    const response = await fetch(address);
    if (!response.ok) throw new Error(`${address} cannot be loaded: ${response.status}`);
    return response;
  }
  const { readFile } = await import(/** @type {any} */ ("node:fs/promises"));
  return new Response(await readFile(address));
}

/**
 * Return what a file of JSON says; it is loaded once.
 * @param {URL} address
 * @returns {Promise<any>}
 */
export function loadJson(address) {
  return once(address.href, async () => (await contentOf(address)).json());
}

/**
 * Return what the modules have and what lies where in their memory.
 * @returns {Promise<Layout>}
 */
export function loadLayout() {
  return loadJson(new URL("layout.json", FOLDER));
}

/**
 * Return the compiled code of a module, without SIMD for browsers that lack it.
 * @param {string} name `one`, `two` or `lanes`
 */
export function loadModule(name) {
  const file = `${name}${WebAssembly.validate(SIMD) ? "" : "-scalar"}.wasm`;
  const address = new URL(file, FOLDER);
  return once(file, async () => WebAssembly.compile(await (await contentOf(address)).arrayBuffer()));
}

/**
 * Return a module that is ready to be called; all who ask share its memory.
 * @param {string} name `one`, `two` or `lanes`
 */
export function loadKernels(name) {
  return once(name, () => startKernels(name));
}

/**
 * Return a module with a memory of its own.
 * @param {string} name
 */
export async function startKernels(name) {
  const [layout, module] = await Promise.all([loadLayout(), loadModule(name)]);
  return Kernels.start(module, name, layout);
}
