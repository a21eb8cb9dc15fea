/** Stories and challenges of the site, which Python made of their files. */

import { loadJson } from "../kernels/files.js";
import { InputError } from "../model/rules.js";
import { stopped } from "../page/link_parts.js";
import { inLanguage } from "../page/refusals.js";
import { t } from "../strings.js";
import { check } from "./check.js";

/** @typedef {import("./check.js").StoryTable} StoryTable */
/** @typedef {import("./check.js").Schema} Schema */
/** @typedef {{name: string, tables?: StoryTable, error?: string}} StoryEntry */

/** @returns {Promise<Schema>} */
export function loadSchema() {
  return loadJson("stories/schema.json");
}

/** Return the tables of all files by their names. @returns {Promise<Record<string, StoryTable>>} */
function loadTables() {
  return loadJson("stories/contents.json");
}

/**
 * Return the stories of the site in their order; one that cannot be told has its error instead.
 * @param {import("../model/registry.js").Registry} registry
 * @returns {Promise<StoryEntry[]>}
 */
export async function loadAll(registry) {
  const entries = await Promise.all(Object.keys(await loadTables()).map(async (name) => {
    try {
      return { name, tables: await load(registry, name) };
    } catch (error) {
      if (!(error instanceof InputError)) throw error;
      return { name, error: inLanguage(error) };
    }
  }));
  const place = (/** @type {StoryEntry} */ { tables }) => tables?.order ?? Number.MAX_VALUE;
  return entries.sort((one, other) => place(one) - place(other));
}

/**
 * Return the tables of a story by its name in the address; throws an InputError with one sentence.
 * @param {import("../model/registry.js").Registry} registry
 * @param {string} name
 */
export async function load(registry, name) {
  const [all, schema] = await Promise.all([loadTables(), loadSchema()]);
  if (!Object.hasOwn(all, name)) throw new InputError(t("storyUnknown", { name }));
  try {
    check(registry, schema, all[name]);
  } catch (error) {
    throw error instanceof InputError
      ? new InputError(t("storiesBroken", { name, error: stopped(inLanguage(error)) })) : error;
  }
  return all[name];
}
