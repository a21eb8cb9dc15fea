/** Compiled modules from their files, in a page, in a worker and in Node.js. */

import { Kernels } from "./memory.js";

/** @typedef {import("./memory.js").Layout} Layout */

const FOLDER = new URL("../../kernels/", import.meta.url);
/** @type {Promise<Layout> | null} */
let layout = null;
/** @type {Map<string, Promise<Kernels>>} */
const modules = new Map();

/**
 * Return the content of a file, also where no server has it: in Node.js.
 * @param {URL} address
 */
export async function contentOf(address) {
  if (address.protocol !== "file:") {
    const response = await fetch(address);
    if (!response.ok) throw new Error(`${address} cannot be loaded: ${response.status}`);
    return response;
  }
  const { readFile } = await import(/** @type {any} */ ("node:fs/promises"));
  return new Response(await readFile(address));
}

/** Return what the modules have and what lies where in their memory. */
export function loadLayout() {
  layout ??= contentOf(new URL("layout.json", FOLDER)).then((response) => response.json()).catch((error) => {
    layout = null; // to be tried again
    throw error;
  });
  return layout;
}

/**
 * Return a module that is ready to be called; it is loaded once.
 * @param {string} name `one`, `two` or `lanes`
 */
export function loadKernels(name) {
  const started = modules.get(name) ?? startKernels(name).catch((error) => {
    modules.delete(name);
    throw error;
  });
  modules.set(name, started);
  return started;
}

/**
 * Return a module with a memory of its own.
 * @param {string} name
 */
export async function startKernels(name) {
  const [about, code] = await Promise.all([
    loadLayout(), contentOf(new URL(`${name}.wasm`, FOLDER)).then((response) => response.arrayBuffer())]);
  return Kernels.start(await WebAssembly.compile(code), name, about);
}
