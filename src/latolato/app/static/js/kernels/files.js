/** The files of this site that are loaded once: texts and tables. */

import { contentOf } from "./content.js";

/** @type {Map<string, Promise<any>>} */
const loaded = new Map();

/**
 * A value that is loaded once; after an error loading is tried again.
 * @template T
 * @param {string} name
 * @param {() => Promise<T>} load
 * @returns {Promise<T>}
 */
export function once(name, load) {
  const result = loaded.get(name) ?? load().catch((error) => {
    loaded.delete(name);
    throw error;
  });
  loaded.set(name, result);
  return result;
}

/**
 * The content of a JSON file, which is loaded once.
 * @param {string} path
 * @returns {Promise<any>}
 */
export function loadJson(path) {
  return once(path, async () => (await contentOf(path)).json());
}

/**
 * The content of a text file, which is loaded once.
 * @param {string} path
 * @returns {Promise<string>}
 */
export function loadText(path) {
  return once(path, async () => (await contentOf(path)).text());
}
