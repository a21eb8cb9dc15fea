/** What is wrong with a story, in one sentence. */

import { optionsOf } from "../model/options.js";
import { InputError, suggest } from "../model/rules.js";
import { toSi } from "../model/units.js";

/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {Record<string, any>} Table */
/**
 * What files may hold: `stories/schema.json`. An entry is a type, the name of a table, or such in a
 * list with the least and the most of them; one whose name ends in "?" may be left out.
 * @typedef {{format: number, kinds: string[], tables: Record<string, Record<string, any>>,
 *   views: string[], rules: Record<string, string>, quantities: Record<string, string>,
 *   need_angle: string[]}} Schema
 */

/** @type {Record<string, [(value: any) => boolean, string]>} */
const TYPES = {
  text: [(value) => typeof value === "string" && value.trim() !== "", "a text"],
  number: [(value) => typeof value === "number" && value > 0, "a number above zero"],
  whole: [(value) => Number.isInteger(value), "a whole number"],
  switch: [(value) => typeof value === "boolean", "true or false"],
  options: [(value) => isTable(value) && Object.values(value).every((part) =>
    ["string", "number"].includes(typeof part) || Array.isArray(part)), "a table of options"],
  extra: [(value) => isTable(value) && Object.entries(value).every(([name, part]) =>
    name.includes(".") && typeof part === "string"), 'a table of texts with names such as "map.x"'],
};
// All other types are written as texts.
const [isText, TEXT] = TYPES.text;

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
    /** @type {Record<string, (table: Table, where: string) => void>} */
    this.checks = { look: this.look, predict: this.predict, condition: this.condition,
      number_shown: this.angle, task: this.task };
  }

  /**
   * @param {Table} table
   * @param {string} kind
   * @param {string} where begins the sentences
   */
  table(table, kind, where) {
    const fields = this.schema.tables[kind];
    const names = Object.keys(fields).map((field) => field.replace("?", ""));
    for (const name of Object.keys(table))
      if (!names.includes(name))
        throw new InputError(`${where}there is no entry '${name}': ${suggest(name, names)}`);
    for (const [field, entry] of Object.entries(fields)) {
      const name = field.replace("?", "");
      if (Object.hasOwn(table, name)) this.value(table[name], entry, name, where);
      else if (name === field) throw new InputError(`${where}${name} is missing`);
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
      if (!Array.isArray(value)) throw new InputError(`${where}${name} must be a list`);
      if (!(value.length >= least && value.length <= most))
        throw new InputError(`${where}${name} must be ${least} to ${most}, got ${value.length}`);
      value.forEach((part, i) => this.value(part, kind, `${kind} ${i + 1}`, where));
      return;
    }
    if (Object.hasOwn(this.schema.tables, entry)) {
      if (!isTable(value)) throw new InputError(`${where}${name} must be a table`);
      this.table(value, entry, `${where ? where.replace(/: $/, ", ") : ""}${name}: `);
      return;
    }
    const [isRight, words] = TYPES[entry] ?? [isText, TEXT];
    if (!isRight(value)) throw new InputError(`${where}${name} must be ${words}`);
    const known = this.known[entry];
    if (known && !known.includes(value))
      throw new InputError(`${where}there is no ${entry} '${value}': ${suggest(value, known)}`);
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
      throw error instanceof InputError ? new InputError(`${where}${error.message}`) : error;
    }
  }

  /** @type {(look: Table, where: string) => void} */
  look({ preset, options = {} }, where) {
    this.within(where, () => optionsOf(this.registry, { scenario: preset, options }));
  }

  /** @type {(predict: Table, where: string) => void} */
  predict({ choices }, where) {
    const right = choices.filter((/** @type {Table} */ choice) => choice.right).length;
    if (right !== 1) throw new InputError(`${where}one choice must be right, got ${right}`);
  }

  /** @type {(condition: Table, where: string) => void} */
  condition(condition, where) {
    const subjects = ["parameter", "quantity", "address"].filter((name) => name in condition);
    if (subjects.length !== 1) throw new InputError(`${where}name one of parameter, quantity, address`);
    if (subjects[0] !== "address")
      this.within(where, () => limitsOf(this.registry, this.schema, condition));
    this.angle(condition, where);
  }

  /** @type {(table: Table, where: string) => void} */
  angle(table, where) {
    const name = table.quantity ?? table.rule;
    if (this.schema.need_angle.includes(name) && !("angle" in table))
      throw new InputError(`${where}angle is missing: ${name} needs one`);
  }

  /** @type {(task: Table, where: string) => void} */
  task(task, where) {
    this.angle(task, where);
    if (task.rule === "guess_tongue" && !("ratios" in task))
      throw new InputError(`${where}ratios is missing: guess_tongue needs them`);
    this.within(where, () => toSi(this.registry, "par", task.par, this.schema.rules[task.rule]));
  }
}

/**
 * Return the least and the largest value that a condition allows [SI].
 * @param {Registry} registry
 * @param {Schema} schema
 * @param {Table} condition
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
 * @param {Table} tables
 */
export function check(registry, schema, tables) {
  const { format = 1, kind = "story" } = tables;
  if (!(Number.isInteger(format) && format >= 1 && format <= schema.format))
    throw new InputError(`it has format ${format}, and this version reads ${schema.format} at most`);
  if (!schema.kinds.includes(kind))
    throw new InputError(`there is no kind '${kind}': ${suggest(kind, schema.kinds)}`);
  new Check(registry, schema).table(tables, kind, "");
}
