/** The lines of Python and of the command line that compute a run again. */

/** @typedef {import("./registry.js").Registry} Registry */
/** @typedef {import("./registry.js").Option} Option */

// What is inherited stands last.
const LAST = "gravity";

/**
 * Return a Python program that makes the run of these options.
 * @param {Registry} registry
 * @param {Record<string, any>} options in SI units
 */
export function pythonLines(registry, options) {
  const { systems, drives } = registry;
  const { system, drive = "fixed_pivot" } = options;
  const lines = ["import latolato as ll", "", `system = ${constructor(registry, systems[system], options)}`];
  const parts = ["system"];
  if (drive !== "fixed_pivot") {
    lines.push(`drive = ${constructor(registry, drives[drive], options)}`);
    parts.push("drive");
  }
  lines.push(`run = ll.simulate(${[...parts, ...runArguments(registry, options)].join(", ")})`);
  return lines.join("\n");
}

/**
 * Return the arguments of a run beside its system and drive; what has its default is left out.
 * @param {Registry} registry
 * @param {Record<string, any>} options
 * @param {string[]} [gone] names of options that are given otherwise
 */
export function runArguments(registry, options, gone = []) {
  const { contact_laws: laws } = registry;
  const given = (/** @type {string} */ owner) => Object.entries(registry.options).filter(([name, option]) =>
    option.owner === owner && !gone.includes(name) && !isUsual(option, options[name]));
  const written = (/** @type {[string, Option]} */ [name, option]) => {
    const law = name === "contact" ? laws[options[name]] : null;
    return `${name}=${law?.options.length ? constructor(registry, law, options) : optionLiteral(option, options[name])}`;
  };
  const noise = given("noise").map(written);
  return [...given("run").filter(([name]) => !Object.values(laws).some((law) => law.options.includes(name))).map(written),
    ...(noise.length ? [`noise=ll.VelocityKicks(${noise.join(", ")})`] : [])];
}

/**
 * Return the call that makes a law; what has its default is left out.
 * @param {Registry} registry
 * @param {import("./registry.js").Law} law
 * @param {Record<string, any>} options
 */
export function constructor(registry, law, options) {
  /** @type {Map<string, string[]>} the parameters of each part of the law, "" for its own */
  const parts = new Map();
  const names = [...law.options.filter((name) => name !== LAST), ...law.options.filter((name) => name === LAST)];
  for (const name of names) {
    const option = registry.options[name];
    if (isUsual(option, options[name])) continue;
    const [outer, inner] = option.path;
    const key = inner === undefined ? "" : outer;
    parts.set(key, [...parts.get(key) ?? [], `${inner ?? outer}=${optionLiteral(option, options[name])}`]);
  }
  const own = parts.get("") ?? [];
  const balls = [...parts].filter(([key]) => key).map(([key, each]) => `${key}=ll.Ball(${each.join(", ")})`);
  return `ll.${law.title}(${[...balls, ...own].join(", ")})`;
}

/** @type {(option: Option, value: any) => boolean} */
export const isUsual = (option, value) => value === undefined || value === null || value === option.default;

/**
 * @param {Option} option
 * @param {any} value
 * @returns {string}
 */
export function optionLiteral(option, value) {
  if (Array.isArray(value)) return `[${value.map((each) => optionLiteral(option, each)).join(", ")}]`;
  if (typeof value === "boolean") return value ? "True" : "False";
  if (typeof value === "string") return `'${value}'`;
  return number(option, value);
}

/**
 * Return a number as Python writes it.
 * @param {Option} option
 * @param {number} value
 */
export function number(option, value) {
  const text = String(value).replace(/e([+-])(\d)$/, "e$10$2");
  return option.unit && !/[.e]/.test(text) ? `${text}.0` : text;
}

/**
 * Return the command that makes the run of these options.
 * @param {Registry} registry
 * @param {Record<string, any>} options in SI units
 */
export function commandLine(registry, options) {
  const words = ["latolato", "simulate"];
  for (const [name, option] of Object.entries(registry.options)) {
    const value = options[name];
    if (isUsual(option, value)) continue;
    words.push(`--${name.replaceAll("_", "-")}`);
    if (typeof value === "boolean") continue;
    const text = [value].flat().map((each) => (typeof each === "number" ? number(option, each) : each)).join(", ");
    words.push(/^[\w.+-]+$/.test(text) ? text : `'${text}'`);
  }
  return words.join(" ");
}
