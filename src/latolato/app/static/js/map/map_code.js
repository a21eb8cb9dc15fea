/** The lines of Python and of the command line that compute a map again. */

import { constructor, isUsual, optionLiteral, runArguments } from "../model/run_code.js";

/** @typedef {import("./question.js").MapQuestion} MapQuestion */

// Options of a run that a sweep does not take, or takes under its own numbers.
const OF_ONE_RUN = ["times", "samples", "frame", "duration", "tolerance"];
const NUMBER = { unit: "s" };
const SIDES = ["right", "left"];

/**
 * Return a Python program that computes a map.
 * @param {MapQuestion} question
 */
export function sweepLines(question) {
  const { registry, options, watched } = question;
  const { systems, drives } = registry;
  const lines = ["import numpy as np", "import latolato as ll", "",
    `system = ${constructor(registry, systems[options.system], options)}`,
    `drive = ${constructor(registry, drives[options.drive], options)}`,
    "grid = ll.sweep(", "    system, drive,", "    axes={",
    ...[question.y, question.x].map((axis) => `        "${axis.name}": np.`
      + `${axis.log ? "geomspace" : "linspace"}(${ends(axis).join(", ")}, ${axis.values.length}),`), "    },",
    `    observables=[${watched.map((each) => inPython(question, each)).join(", ")}],`];
  const run = runArguments(registry, options, setOtherwise(question));
  lines.push(...run.map((each) => `    ${each},`));
  return [...lines, ...numbers(question).map(([name, value]) => `    ${name}=${value},`), ")"].join("\n");
}

/**
 * Return the command that computes a map, quoted for a shell.
 * @param {MapQuestion} question
 */
export function sweepCommand(question) {
  const { registry, options, watched } = question;
  const words = ["latolato", "sweep"];
  const flag = (/** @type {string} */ name) => `--${name.replaceAll("_", "-")}`;
  const varied = [question.x.name, question.y.name];
  const gone = setOtherwise(question);
  for (const [name, option] of Object.entries(registry.options)) {
    const value = options[name];
    if (gone.includes(name) || isUsual(option, value)) continue;
    const sides = SIDES.map((side) => `${name}_${side}`);
    if (sides.some((each) => varied.includes(each))) {
      // Where one ball's value varies, that of the other one is an axis of one value.
      sides.forEach((each, i) => {
        if (!varied.includes(each))
          words.push("--axis", `${each} = ${value[i]} ${registry.axes[each].unit}`);
      });
      continue;
    }
    words.push(flag(name));
    if (value !== true) words.push([value].flat().join(", "));
  }
  for (const [name, value] of numbers(question)) words.push(flag(name), value);
  for (const axis of [question.y, question.x]) {
    const tail = `${axis.log ? " log" : ""}${axis.unit === "1" ? "" : ` ${axis.unit}`}`;
    words.push("--axis", `${axis.name} = ${ends(axis).join(" : ")} : ${axis.values.length}${tail}`);
  }
  for (const each of watched) {
    const own = changed(question, each).map(([name, value]) => `${name} = ${value}`);
    words.push("--observable", own.length ? `${each.name}(${own.join(", ")})` : each.name);
  }
  return words.map((word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word}'`)).join(" ");
}

/** @param {import("./choices.js").Span} axis */
function ends({ low, high }) {
  return [low, high].map((end) => optionLiteral(/** @type {any} */ (NUMBER), end));
}

/**
 * Return the names of options that axes set, or that a sweep does not take.
 * @param {MapQuestion} question
 */
function setOtherwise({ registry, x, y }) {
  const varied = [x, y].map(({ name }) => registry.axes[name].sets);
  return [...OF_ONE_RUN, ...varied, ...(varied.includes("initial_angle") ? ["initial_offset"] : [])];
}

/**
 * Return duration, transient and tolerance.
 * @param {MapQuestion} question
 * @returns {[string, string][]}
 */
function numbers({ registry, duration, transient, periods }) {
  const all = Object.entries({ duration, tolerance: registry.sweep_tolerance, transient,
    transient_periods: periods });
  return all.filter(([, value]) => value)
    .map(([name, value]) => [name, optionLiteral(/** @type {any} */ (NUMBER), value)]);
}

/**
 * Return the parameters of an observable that are not the usual ones.
 * @param {MapQuestion} question
 * @param {import("./choices.js").Watched} watched
 */
function changed({ layout }, { name, parameters }) {
  return Object.entries(parameters).filter(([key, value]) =>
    Number(value) !== layout.observables[name].parameters[key]);
}

/**
 * Return an observable as Python writes it.
 * @param {MapQuestion} question
 * @param {import("./choices.js").Watched} watched
 */
function inPython(question, watched) {
  const own = changed(question, watched).map(([name, value]) =>
    `${name}=${optionLiteral(/** @type {any} */ (NUMBER), value)}`);
  return own.length
    ? `ll.observables.${question.registry.observables[watched.name].title}(${own.join(", ")})`
    : `'${watched.name}'`;
}
