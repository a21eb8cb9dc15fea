/** What is wrong with a story, in one sentence. */

import { optionsOf } from "../model/options.js";
import { InputError, suggest } from "../model/rules.js";
import { toSi } from "../model/units.js";
import { inLanguage, sentenceInLanguage } from "../page/refusals.js";
import { t } from "../strings.js";

/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {Record<string, any>} StoryTable */
/**
 * What files may hold: `stories/schema.json`. An entry is a type, the name of a table, or such in a
 * list with the least and the most of them; one whose name ends in "?" may be left out.
 * @typedef {{format: number, kinds: string[], tables: Record<string, Record<string, any>>,
 *   views: string[], rules: Record<string, string>, quantities: Record<string, string>,
 *   need_angle: string[]}} Schema
 */

/** @type {Record<string, (value: any) => boolean>} */
const TYPES = {
  text: (value) => typeof value === "string" && value.trim() !== "",
  number: (value) => typeof value === "number" && value > 0,
  whole: (value) => Number.isInteger(value),
  switch: (value) => typeof value === "boolean",
  options: (value) => isTable(value) && Object.values(value).every((part) =>
    ["string", "number"].includes(typeof part) || Array.isArray(part)),
  extra: (value) => isTable(value) && Object.entries(value).every(([name, part]) =>
    name.includes(".") && typeof part === "string"),
};

/** @type {(name: string, known: string[]) => string} */
const hintFor = (name, known) => sentenceInLanguage(suggest(String(name), known));

/** @param {any} value */
function isTable(value) {
  return typeof value === "object" && value !== null && !Array.isArray(value) && !(value instanceof Date);
}

/** Checks one file. */
class Check {
  /**
   * @param {Registry} registry
   * @param {Schema} schema
   */
  constructor(registry, schema) {
    this.registry = registry;
    this.schema = schema;
    /** @type {Record<string, string[]>} */
    this.known = { view: schema.views, preset: Object.keys(registry.scenarios),
      parameter: Object.keys(registry.options), quantity: Object.keys(schema.quantities),
      rule: Object.keys(schema.rules) };
    /** @type {Record<string, (table: StoryTable, where: string) => void>} */
    this.checks = { look: this.look, predict: this.predict, condition: this.condition,
      number_shown: this.angle, task: this.task };
  }

  /**
   * @param {StoryTable} table
   * @param {string} kind
   * @param {string} where begins the sentences
   */
  table(table, kind, where) {
    const fields = this.schema.tables[kind];
    const names = Object.keys(fields).map((field) => field.replace("?", ""));
    for (const name of Object.keys(table))
      if (!names.includes(name))
        throw new InputError(t("storyEntry", { where, name, text: hintFor(name, names) }));
    for (const [field, entry] of Object.entries(fields)) {
      const name = field.replace("?", "");
      if (Object.hasOwn(table, name)) this.value(table[name], entry, name, where);
      else if (name === field) throw new InputError(t("storyMissing", { where, name }));
    }
    this.checks[kind]?.call(this, table, where);
  }

  /**
   * @param {any} value
   * @param {any} entry
   * @param {string} name
   * @param {string} where
   */
  value(value, entry, name, where) {
    if (Array.isArray(entry)) {
      const [kind, least, most] = entry;
      if (!Array.isArray(value)) throw new InputError(t("storyList", { where, name }));
      if (!(value.length >= least && value.length <= most))
        throw new InputError(t("storyCount", { where, name, least, most, count: value.length }));
      value.forEach((part, i) => this.value(part, kind, `${kind} ${i + 1}`, where));
      return;
    }
    if (Object.hasOwn(this.schema.tables, entry)) {
      if (!isTable(value)) throw new InputError(t("storyTable", { where, name }));
      this.table(value, entry, `${where ? where.replace(/: $/, ", ") : ""}${name}: `);
      return;
    }
    // All other types are written as texts.
    const type = Object.hasOwn(TYPES, entry) ? entry : "text";
    if (!TYPES[type](value)) throw new InputError(t("storyType", { where, name, kind: t(`storyType_${type}`) }));
    const known = this.known[entry];
    if (known && !known.includes(value))
      throw new InputError(t(`storyUnknown_${entry}`, { where, name: value, text: hintFor(value, known) }));
    if (entry === "angle") this.within(where, () => toSi(this.registry, name, value, "rad"));
  }

  /**
   * Do something; a refusal says where in the file it belongs.
   * @param {string} where
   * @param {() => void} work
   */
  within(where, work) {
    try {
      work();
    } catch (error) {
      throw error instanceof InputError ? new InputError(`${where}${inLanguage(error)}`) : error;
    }
  }

  /** @type {(look: StoryTable, where: string) => void} */
  look({ preset, options = {} }, where) {
    this.within(where, () => optionsOf(this.registry, { scenario: preset, options }));
  }

  /** @type {(predict: StoryTable, where: string) => void} */
  predict({ choices }, where) {
    const right = choices.filter((/** @type {StoryTable} */ choice) => choice.right).length;
    if (right !== 1) throw new InputError(t("storyChoice", { where, count: right }));
  }

  /** @type {(condition: StoryTable, where: string) => void} */
  condition(condition, where) {
    const subjects = ["parameter", "quantity", "address"].filter((name) => name in condition);
    if (subjects.length !== 1) throw new InputError(t("storySubject", { where }));
    if (subjects[0] !== "address")
      this.within(where, () => limitsOf(this.registry, this.schema, condition));
    this.angle(condition, where);
  }

  /** @type {(table: StoryTable, where: string) => void} */
  angle(table, where) {
    const name = table.quantity ?? table.rule;
    if (this.schema.need_angle.includes(name) && !("angle" in table))
      throw new InputError(t("storyAngle", { where, name }));
  }

  /** @type {(task: StoryTable, where: string) => void} */
  task(task, where) {
    this.angle(task, where);
    if (task.rule === "guess_tongue" && !("ratios" in task))
      throw new InputError(t("storyRatios", { where }));
    this.within(where, () => toSi(this.registry, "par", task.par, this.schema.rules[task.rule]));
  }
}

/**
 * Return the least and the largest value that a condition allows [SI].
 * @param {Registry} registry
 * @param {Schema} schema
 * @param {StoryTable} condition
 */
export function limitsOf(registry, schema, condition) {
  const unit = condition.quantity ? schema.quantities[condition.quantity]
    : registry.options[condition.parameter].unit;
  const end = (/** @type {string} */ name, /** @type {number} */ otherwise) =>
    (name in condition ? toSi(registry, name, condition[name], unit) : otherwise);
  return [end("at_least", -Infinity), end("at_most", Infinity)];
}

/**
 * Throw an InputError with one sentence if something is wrong with the tables of a file.
 * @param {Registry} registry
 * @param {Schema} schema
 * @param {StoryTable} tables
 */
export function check(registry, schema, tables) {
  const { format = 1, kind = "story" } = tables;
  if (!(Number.isInteger(format) && format >= 1 && format <= schema.format))
    throw new InputError(t("storyFormat", { format, newest: schema.format }));
  if (!schema.kinds.includes(kind))
    throw new InputError(t("storyUnknown_kind", { where: "", name: kind, text: hintFor(kind, schema.kinds) }));
  new Check(registry, schema).table(tables, kind, "");
}
