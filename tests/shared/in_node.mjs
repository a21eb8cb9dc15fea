// Runs what `in_node.py` prepared: node in_node.mjs FOLDER-OF-MODULES FOLDER-OF-CASES
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { begin, shake } from "../../src/latolato/app/static/js/kernels/begin.js";
import { Kernels } from "../../src/latolato/app/static/js/kernels/memory.js";
import { computeMap } from "../../src/latolato/app/static/js/kernels/map.js";
import { normals } from "../../src/latolato/app/static/js/kernels/noise.js";
import { runPoints } from "../../src/latolato/app/static/js/kernels/points.js";
import { integrate, observe } from "../../src/latolato/app/static/js/kernels/run.js";

const [modules, folder] = process.argv.slice(2);
const layout = JSON.parse(readFileSync(join(modules, "layout.json"), "utf8"));
const given = readFileSync(join(folder, "given.bin"));

/** Return the module of a file, of whatever variant. */
async function started(file) {
  const module = await WebAssembly.compile(readFileSync(join(modules, `${file}.wasm`)));
  return Kernels.start(module, file.split("-")[0], layout);
}

/** Put arrays into the memory of a module, by name. */
function held(kernels, arrays) {
  return Object.fromEntries(arrays.map(({ name, type, shape, at }) => {
    const found = kernels.take(type, ...shape);
    const bytes = kernels.bytes(found);
    bytes.set(given.subarray(at, at + bytes.length));
    return [name, found];
  }));
}

const found = { arrays: [], about: [] };
const parts = [];
let end = 0;

/** Note an array of a case for Python. */
function give(name, bytes) {
  found.arrays.at(-1).push({ name, at: end, size: bytes.length });
  parts.push(Buffer.from(bytes));
  end += bytes.length;
}

const bytesOf = (numbers) => new Uint8Array(numbers.buffer, numbers.byteOffset, numbers.byteLength);

/**
 * The run of some parameters, with its record. It is repeated with half the step as long as the energy
 * ledger closes worse than the tolerance allows, some times at most; `closes` says whether it did at last.
 */
function simulate(kernels, parameters, inputs, how) {
  const { most_halvings, most_steps_to_repeat } = kernels.layout;
  let step = Number(parameters.step ?? 0);
  for (let halvings = 0; ; halvings += 1) {
    const { run, problem } = begin(kernels, { ...parameters, step }, inputs.segments);
    if (problem) throw new Error(problem.name);
    const end = integrate(kernels, { ...inputs, run }, how);
    const allowed = kernels.exports.allowed(run.at, parameters.tolerance);
    const closes = kernels.get(run, "state.ledger_error") <= allowed;
    const steps = kernels.get(run, "state.total_steps");
    if (closes || how.engine === "clamp" || end.status !== "complete"
      || halvings === most_halvings || steps > most_steps_to_repeat) {
      return { ...end, run, halvings, closes };
    }
    step = 0.5 * kernels.get(run, "settings.step");
    kernels.release(run);
  }
}

function run(kernels, memory, { how, seen, parameters }) {
  if (parameters) memory.segments = shake(kernels, parameters.kind, parameters.drive);
  const start = performance.now();
  const { samples, contacts, run: record, ...about } = parameters
    ? simulate(kernels, parameters.case, memory, how) : integrate(kernels, memory, how);
  if (record) memory.run = record;
  about.seconds = (performance.now() - start) / 1e3;
  return [about, () => {
    give("samples", kernels.bytes(samples));
    give("contact_times", bytesOf(contacts.times));
    give("contact_kinds", bytesOf(contacts.kinds));
    give("contact_values", Buffer.concat(contacts.values.map(bytesOf)));
    give("run", kernels.bytes(memory.run));
    const { pivot, out } = observe(kernels, memory, samples, { balls: memory.balls, ...seen });
    give("pivot", kernels.bytes(pivot));
    give("out", kernels.bytes(out));
  }];
}

function points(kernels, memory, { contact_limit, slots, is_linear, callbacks, lanes }) {
  const under = (tuple) => Object.fromEntries(Object.entries(memory)
    .filter(([name]) => name.startsWith(`${tuple}.`))
    .map(([name, value]) => [name.slice(tuple.length + 1), value]));
  const progress = under("progress");
  const all = { order: memory.order, points: { ...under("points"), contact_limit }, progress,
    stepper: under("stepper"), slots, is_linear };
  const start = performance.now();
  runPoints(kernels, all, callbacks, lanes);
  const seconds = (performance.now() - start) / 1e3;
  return [{ seconds }, () => {
    for (const [name, array] of Object.entries(progress)) give(name, kernels.bytes(array));
  }];
}

/** Compute a map whose columns are arrays of the case by their paths, with a mark of what they are. */
function map(kernels, arrays, { question }) {
  const columns = (kind) => Object.fromEntries(arrays
    .filter(({ name }) => name.startsWith(`${kind}:`))
    .map(({ name, shape, at }) => {
      const bytes = Uint8Array.from(given.subarray(at, at + 8 * shape[0]));
      return [name.slice(kind.length + 1), new Float64Array(bytes.buffer)];
    }));
  if (question.refused) {
    const before = kernels.take("f8", 0).at;
    try {
      computeMap(kernels, { ...question, ...columns("question") });
    } catch (error) {
      return [{ seconds: 0, error: error.message, left: kernels.top - before }, () => {}];
    }
    return [{ seconds: 0, error: null }, () => {}];
  }
  const start = performance.now();
  const { status, problems, values } = computeMap(kernels, { ...question, ...columns("question"),
    parameters: { ...question.parameters, ...columns("parameter") },
    drive: { ...question.drive, parameters: columns("drive") },
    noise: question.noise ?? (columns("noise").noise_strength && columns("noise")) });
  const seconds = (performance.now() - start) / 1e3;
  return [{ seconds, problems: [...problems] }, () => {
    give("status", bytesOf(Float64Array.from(status)));
    for (const [name, numbers] of Object.entries(values)) give(name, bytesOf(numbers));
  }];
}

/** Draw random numbers into arrays that are called by their keys. */
function normalNumbers(kernels, arrays) {
  const drawn = arrays.map(({ name, shape }) => {
    const next = normals(name.split(" ").map(BigInt));
    return [name, Float64Array.from({ length: shape[0] }, next)];
  });
  return [{ seconds: 0 }, () => drawn.forEach(([name, numbers]) => give(name, bytesOf(numbers)))];
}

const known = {};
for (const { module, repeats, arrays, ...options } of JSON.parse(
  readFileSync(join(folder, "given.json"), "utf8"))) {
  const kernels = (known[module] ??= await started(module));
  found.arrays.push([]);
  const first = kernels.take("f8", 1);
  let least = Infinity;
  for (let i = 1; i <= repeats; i += 1) {
    const [about, giveAll] = options.normals ? normalNumbers(kernels, arrays)
      : options.question ? map(kernels, arrays, options)
      : (options.how ? run : points)(kernels, held(kernels, arrays), options);
    least = Math.min(least, about.seconds);
    if (i === repeats) {
      giveAll();
      found.about.push({ ...about, seconds: least });
    }
    kernels.release(first);
  }
}
writeFileSync(join(folder, "found.bin"), Buffer.concat(parts));
writeFileSync(join(folder, "found.json"), JSON.stringify(found));
