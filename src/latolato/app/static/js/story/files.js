/** Story files: those of the site, and one from the reader's own computer. */

import { loadJson } from "../kernels/load.js";
import { contentOf } from "../kernels/content.js";
import { InputError } from "../model/rules.js";
import { inLanguage } from "../model/words.js";
import { stopped } from "../shared/reading.js";
import { keep, recall } from "../shared/habits.js";
import { t } from "../strings.js";
import { check } from "./check.js";

/** @typedef {import("./check.js").Table} Table */
/** @typedef {import("./check.js").Schema} Schema */
/** @typedef {{name: string, tables?: Table, error?: string}} Entry */

/** Stands in the address for the file that the reader opened. */
export const OWN = "own-file";
const KEY = "latolato.story";

/** @returns {Promise<Schema>} */
export function loadSchema() {
  return loadJson("stories/schema.json");
}

/** Return the names of the site's files. @returns {Promise<string[]>} */
function loadNames() {
  return loadJson("stories/contents.json");
}

/**
 * Return the files of the site in their order; one that cannot be told has its error instead.
 * @param {import("../model/registry.js").Registry} registry
 * @returns {Promise<Entry[]>}
 */
export async function loadAll(registry) {
  const entries = await Promise.all((await loadNames()).map(async (name) => {
    try {
      return { name, tables: await load(registry, name) };
    } catch (error) {
      if (!(error instanceof InputError)) throw error;
      return { name, error: inLanguage(error) };
    }
  }));
  const place = (/** @type {Entry} */ { tables }) => tables?.order ?? Number.MAX_VALUE;
  return entries.sort((one, other) => place(one) - place(other));
}

/**
 * Return the tables of a text in TOML, checked.
 * @param {import("../model/registry.js").Registry} registry
 * @param {string} text
 * @returns {Promise<Table>}
 */
export async function read(registry, text) {
  const [{ parse }, schema] = await Promise.all([
    import("../../vendor/smol-toml/parse.js"), loadSchema()]);
  // Browsers put this mark where bytes are no text.
  if (text.includes("\uFFFD")) throw new InputError("this is not a text in UTF-8");
  /** @type {Table} */
  let tables;
  try {
    tables = parse(text);
  } catch (error) {
    throw new InputError(`this is not TOML: look at line ${/** @type {any} */ (error).line}`);
  }
  check(registry, schema, tables);
  return tables;
}

/**
 * Return the tables of a story by its name in the address; throws an InputError with one sentence.
 * @param {import("../model/registry.js").Registry} registry
 * @param {string} name
 */
export async function load(registry, name) {
  if (name === OWN) {
    const kept = ownFile();
    if (kept) return named(kept.name, () => read(registry, kept.text));
    throw new InputError(t("storyOwnGone"));
  }
  if (!(await loadNames()).includes(name))
    throw new InputError(t("storyUnknown", { name }));
  const text = await (await contentOf(`stories/${name}.toml`)).text();
  return named(`${name}.toml`, () => read(registry, text));
}

/**
 * The result of `work`; a refusal names the file.
 * @param {string} name
 * @param {() => Promise<Table>} work
 */
async function named(name, work) {
  try {
    return await work();
  } catch (error) {
    throw error instanceof InputError
      ? new InputError(t("storiesBroken", { name, error: stopped(inLanguage(error)) })) : error;
  }
}

/** Return the name and the text of the file that the reader opened, null without one. */
function ownFile() {
  try {
    const kept = JSON.parse(recall(KEY, "sessionStorage") ?? "null");
    return kept && typeof kept.text === "string" ? kept : null;
  } catch {
    return null;
  }
}

/**
 * Keep a file until the tab is closed.
 * @param {string} name
 * @param {string} text
 */
export function keepOwnFile(name, text) {
  keep(KEY, JSON.stringify({ name, text }), "sessionStorage");
}
