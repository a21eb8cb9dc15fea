/** Compiled modules from their files, in a page, in a worker and in Node.js. */

import { contentOf } from "./content.js";
import { loadJson, once } from "./files.js";
import { Kernels } from "./memory.js";

/** @typedef {import("./memory.js").Layout} Layout */

// A module of one function that needs simd128: it counts the bits of each byte of a vector.
const SIMD = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10,
  1, 8, 0, 65, 0, 253, 15, 253, 98, 11]);

/**
 * The layout of the modules: what they contain, and its place in their memory.
 * @returns {Promise<Layout>}
 */
export function loadLayout() {
  return loadJson("kernels/layout.json");
}

/**
 * Return the name of the module that runs one ball or two.
 * @param {number} angles
 * @param {boolean} inPlane whether balls leave their circles, or are moved or blown sideways
 */
export function moduleFor(angles, inPlane) {
  return `${inPlane ? "plane_" : ""}${angles === 2 ? "two" : "one"}`;
}

/** Return how the names of modules end that this browser runs: those without SIMD if it lacks it. */
export function variant() {
  return WebAssembly.validate(SIMD) ? "" : "-scalar";
}

/**
 * Return the compiled code of a module.
 * @param {string} name one of the layout's modules
 */
export function loadModule(name) {
  const path = `kernels/${name}${variant()}.wasm`;
  return once(path, async () => WebAssembly.compile(await (await contentOf(path)).arrayBuffer()));
}

/** Load what most runs need; a run that needs it reports a fault. */
export function loadAhead() {
  for (const load of [loadLayout, () => loadModule("one")]) load().catch(() => {});
}

/**
 * Return a module that is ready to be called; all who ask share its memory.
 * @param {string} name
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
