/** Stories and challenges of the site, which Python made of their files and has checked. */

import { loadJson } from "../kernels/files.js";

/**
 * A table of a file, and what files may hold: `stories/schema.json`, with the units of scores and quantities.
 * @typedef {Record<string, any>} StoryTable
 * @typedef {{rules: Record<string, string>, quantities: Record<string, string>}} Schema
 */

/** @returns {Promise<Schema>} */
export function loadSchema() {
  return loadJson("stories/schema.json");
}

/** Return the tables of all files by their names, in the order of the list. @returns {Promise<Record<string, StoryTable>>} */
export function loadTables() {
  return loadJson("stories/contents.json");
}
