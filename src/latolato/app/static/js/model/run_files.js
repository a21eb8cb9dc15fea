/** Files of a run, as Python writes and reads them: its columns, its contacts, its scenario. */

import { commandLine } from "./run_code.js";

/** @typedef {import("./registry.js").Registry} Registry */
/** @typedef {import("../page/block.js").Block} Block */

const SIDES = ["right", "left"];
const LEDGER = ["drive_work", "damping_loss", "impact_loss", "capture_loss", "noise_work", "retension_loss"];
// Variables whose names say whether they are those of one ball or of both.
const OF_BALLS = ["kinetic_energy", "potential_energy", "total_energy", "drive_power", "damping_power",
  "tension", "lab_energy", "rod_power", ...LEDGER];

// Units in which people read numbers: how many places the point moves, and the size of a degree [rad].
const POWERS = /** @type {Record<string, number>} */ ({ mm: 3, cm: 2, g: 3 });
const DEGREE = Math.PI / 180;

/**
 * Return a number in SI units in another unit; back in SI units it may differ in its last digit.
 * @param {number} value
 * @param {string} unit
 */
function inUnit(value, unit) {
  if (unit === "deg" || !Number.isFinite(value)) return value / DEGREE;
  // Only the point moves: 0.07 m are 70 mm, and not 70.00000000000001.
  const [digits, exponent] = value.toExponential().split("e");
  return Number(`${digits}e${Number(exponent) + POWERS[unit]}`);
}

/**
 * Return the tables of a scenario that sets these options.
 * @param {Registry} registry
 * @param {Record<string, any>} options in SI units
 * @returns {Record<string, any>}
 */
export function tablesOf(registry, options) {
  /** @type {Record<string, any>} */
  const tables = {};
  for (const [name, { owner, path }] of Object.entries(registry.options)) {
    const value = options[name];
    if (value === undefined || value === null) continue;
    let place = (tables[owner] ??= {});
    for (const part of path.slice(0, -1)) place = (place[part] ??= {});
    place[path[path.length - 1]] = value;
  }
  return tables;
}

/**
 * Return the scenario of a run as a file in TOML.
 * @param {Registry} registry
 * @param {Block} block
 * @param {string} name of the file
 */
export function tomlOf(registry, { about }, name) {
  const lines = [`# SI units. Run it: latolato simulate ${name}`,
    `# The same on one line: ${commandLine(registry, about.options)}`];
  const write = (/** @type {string} */ title, /** @type {Record<string, any>} */ table) => {
    const isTable = (/** @type {[string, any]} */ [, value]) => typeof value === "object" && !Array.isArray(value);
    const entries = Object.entries(table);
    lines.push("", `[${title}]`);
    // JSON's texts, numbers, switches and lists are TOML's too.
    for (const [key, value] of entries.filter((each) => !isTable(each)))
      lines.push(`${key} = ${JSON.stringify(value)}`);
    for (const [key, value] of entries.filter(isTable)) write(`${title}.${key}`, value);
  };
  for (const [title, table] of Object.entries(tablesOf(registry, about.options))) write(title, table);
  return `${lines.join("\n")}\n`;
}

/**
 * Return the columns of a run as a table of comma-separated values.
 * @param {Registry} registry
 * @param {Block} block
 */
export function columnsTable(registry, block) {
  const names = Object.keys(block.arrays).filter((name) =>
    name !== "strobe" && !(name in CONTACT_COLUMNS));
  return table(registry, block, names);
}

/** @type {Record<string, true>} */
const CONTACT_COLUMNS = { contact_time: true, contact_kind: true, angular_velocity_before: true,
  angular_velocity_after: true, radial_velocity_before: true, radial_velocity_after: true, contact_ball: true };

/**
 * Return the contacts of a run as a table of comma-separated values.
 * @param {Registry} registry
 * @param {Block} block
 */
export function contactsTable(registry, block) {
  return table(registry, block, Object.keys(CONTACT_COLUMNS).filter((name) => name in block.arrays));
}

/**
 * @param {Registry} registry
 * @param {Block} block
 * @param {string[]} names
 */
function table(registry, { about, arrays, shapes }, names) {
  const two = registry.systems[about.options.system].angles === 2;
  const isToy = registry.systems[about.options.system].contacts;
  const isString = about.options.suspension === "string";
  const columns = names.flatMap((name) => {
    const { unit, shown_unit: shownUnit, ...quantity } = registry.quantities[name];
    const label = isString ? quantity.label.replace("of the rod", "of the string") : quantity.label;
    const shape = shapes[name];
    const length = shape[shape.length - 1];
    const values = arrays[name];
    const isBoth = two && LEDGER.includes(name);
    const whose = isToy && OF_BALLS.includes(name) ? isBoth ? ", both balls" : ", per ball" : "";
    const rows = two && shape.length === 2 && shape[0] === 2 ? SIDES : [""];
    return rows.map((side, row) => {
      const at = name === "contact_kind"
        ? (/** @type {number} */ i) => about.contact_kinds[values[i]]
        : (/** @type {number} */ i) => values[row * length + i];
      return column(side ? `${name}_${side}` : name, { unit, shownUnit, label: label + whose }, at);
    });
  });
  return csv(registry, about.attributes, columns, shapes[names[0]][0]);
}

/**
 * Return a column of a table, in the unit in which people read it where files have that.
 * @param {string} name
 * @param {{unit: string, shownUnit: string, label: string}} quantity
 * @param {(i: number) => any} at returns its cells, numbers in SI units
 */
export function column(name, { unit, shownUnit, label }, at) {
  if (shownUnit !== "deg" && !Object.hasOwn(POWERS, shownUnit)) return { head: name, title: `# column ${name} [${unit}]: ${label}`, at };
  const head = `${name} [${shownUnit}]`;
  return { head, title: `# column ${head}: ${label}`, at: (/** @type {number} */ i) => inUnit(at(i), shownUnit) };
}

/**
 * Return a table of comma-separated values.
 * @param {Registry} registry
 * @param {Record<string, any>} attributes that stand above it
 * @param {ReturnType<typeof column>[]} columns
 * @param {number} count of the rows
 */
export function csv(registry, attributes, columns, count) {
  const above = Object.entries(attributes).map(([name, value]) =>
    `# ${headWithUnit(registry, name)}: ${typeof value === "string" ? value : json(value)}`);
  const lines = [...above, ...columns.map(({ title }) => title), columns.map(({ head }) => head).join(",")];
  for (let i = 0; i < count; i += 1)
    lines.push(columns.map(({ at }) => String(at(i)).replace("NaN", "nan").replace("Infinity", "inf")).join(","));
  return `${lines.join("\n")}\n`;
}

/**
 * Return the name of what stands above the columns of a table, with the unit of its value if it has one.
 * @param {Registry} registry
 * @param {string} name
 */
function headWithUnit({ quantities }, name) {
  const { unit = "1" } = quantities[name.replace(/^(right|left)_/, "")] ?? {};
  return unit === "1" ? name : `${name} [${unit}]`;
}

/**
 * Return a value as Python's JSON has it, which knows numbers that are none.
 * @param {any} value
 * @returns {string}
 */
function json(value) {
  if (Array.isArray(value)) return `[${value.map(json).join(", ")}]`;
  return typeof value === "number" && !Number.isFinite(value) ? String(value) : JSON.stringify(value);
}
