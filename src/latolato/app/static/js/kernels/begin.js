/** From the parameters of a drive and a run to the run's beginning, as `latolato.numerics.host_entry`. */

/**
 * @typedef {import("./memory.js").HeldMemory} HeldMemory
 * @typedef {import("./memory.js").Kernels} Kernels
 *
 * A problem and the values that its rule names.
 * @typedef {import("./memory.js").Problem & {reported: number[]}} Reported
 */

// Fields of a case that are no number where they are not given.
export const ABSENT = { initial_offset: NaN, pivot_bound: NaN, drive_rate: NaN,
  "initial_distance.0": NaN, "initial_distance.1": NaN };

/**
 * Return the segments of a drive's motion.
 * @param {Kernels} kernels
 * @param {string} kind such as `harmonic`; a measured pivot has its segments from Python
 * @param {Record<string, number | number[]>} parameters as `Drive.numbers` in Python
 */
export function shake(kernels, kind, parameters) {
  return shakeAll(kernels, kind, parameters, 1).segments;
}

/**
 * Return the segments of several drives one after the other, and where those of each begin.
 * @param {Kernels} kernels
 * @param {string} kind
 * @param {Record<string, number | number[] | Float64Array>} parameters as for `shake`; a
 *   `Float64Array` has a number for each drive
 * @param {number} count
 */
export function shakeAll(kernels, kind, parameters, count) {
  const { bundles, drives } = kernels.layout;
  const place = drives.findIndex(({ name }) => name === kind);
  if (place < 0) throw new Error(`no drive is called ${kind}`);
  const known = bundles.shaking.map(({ name }) => name.slice("drive.".length));
  const wrong = Object.keys(parameters).find((name) => !known.includes(name));
  if (wrong !== undefined) throw new Error(`no drive has the parameter ${wrong}`);
  const times = parameters.times ?? [];
  // A change takes two segments; one more lies before all of them, and one behind.
  const room = 2 * (Array.isArray(times) ? times.length : 1) + 2;
  const segments = kernels.take("segment", count * room);
  const firsts = kernels.take("i8", count + 1);
  const number = kernels.take("i8", 1);
  /** @type {Record<string, HeldMemory | number>} */
  const values = { segments, number };
  /** @type {[number, Float64Array][]} */
  const columns = [];
  for (const { name, dimensions } of bundles.shaking) {
    if (name in values) continue;
    const value = parameters[name.slice("drive.".length)] ?? 0;
    if (value instanceof Float64Array) columns.push([kernels.place("shaking", name), value]);
    values[name] = dimensions === undefined ? Number(value instanceof Float64Array ? NaN : value)
      : kernels.copy(Array.isArray(value) ? value : []);
  }
  values["drive.kind"] = place;
  const words = kernels.words("shaking");
  kernels.fill(words, "shaking", values);
  const integers = kernels.numbers(words);
  const floats = kernels.numbers({ ...words, type: "f8" });
  const begins = kernels.numbers(firsts);
  const written = kernels.numbers(number);
  const at = kernels.place("shaking", "segments");
  let size = 0;
  for (let k = 0; k < count; k += 1) {
    for (const [word, column] of columns) floats[word] = column[k];
    integers[at] = BigInt(segments.at + size * kernels.size("segment"));
    kernels.exports.shake(words.at);
    size += Number(written[0]);
    begins[k + 1] = BigInt(size);
  }
  return { segments: { ...segments, shape: [size] }, firsts };
}

/**
 * Return the record of a run at time zero, the fastest angular frequency of its drive [rad/s], and
 * what is wrong with its parameters, null if nothing is.
 * @param {Kernels} kernels of a module that runs so many balls
 * @param {Record<string, number | number[]>} parameters fields of the record `case` by their paths,
 *   such as `balls.0.mass`; others are zero, an offset, distances and bounds of the drive not given
 * @param {HeldMemory} segments of the drive
 */
export function begin(kernels, parameters, segments) {
  const run = kernels.take("run", 1);
  const held = kernels.take("problem", 1);
  const record = kernels.take("case", 1);
  for (const [path, value] of Object.entries({ ...ABSENT, ...parameters })) {
    kernels.set(record, path, ...[value].flat());
  }
  kernels.call("begin", "beginning", { case: record, segments, run, problem: held });
  return { run, problem: problemAt(kernels, held, 0), driveRate: kernels.get(run, "settings.drive_rate") };
}

/**
 * The problem that a record reports, null if there is none.
 * @param {Kernels} kernels
 * @param {HeldMemory} records
 * @param {number} index
 * @returns {Reported | null}
 */
export function problemAt(kernels, records, index) {
  const number = kernels.get(records, "number", index);
  if (number === 0) return null;
  return { ...kernels.layout.problems[number],
    reported: [...kernels.numbers(kernels.field(records, "values", index))] };
}

/**
 * Return a problem that pages find themselves.
 * @param {import("./memory.js").Layout} layout
 * @param {string} name
 * @param {number[]} reported
 * @returns {Reported}
 */
export function problemOf({ problems }, name, reported) {
  const found = problems.find((problem) => problem.name === name);
  if (!found) throw new Error(`no problem is called ${name}`);
  return { ...found, reported };
}
