/** From the parameters of a drive and a run to the run's beginning, as `latolato.numerics.whole`. */

/**
 * @typedef {import("./memory.js").Held} Held
 * @typedef {import("./memory.js").Kernels} Kernels
 */

// Fields of a case that are no number where they are not given.
export const ABSENT = { initial_offset: NaN, pivot_bound: NaN, drive_rate: NaN };
// The usual side of a crank's guide.
const BELOW = -1;

/**
 * Return the stretches of a drive's motion.
 * @param {Kernels} kernels of the module `one` or `two`
 * @param {string} kind such as `harmonic`; a measured pivot has its stretches from Python
 * @param {Record<string, number | number[]>} parameters by the names that Python has, but `side`
 *   for a crank's guide: 1 above, -1 below
 */
export function shake(kernels, kind, parameters) {
  const { bundles, drives } = kernels.layout;
  if (!drives.includes(kind)) throw new Error(`no drive is called ${kind}`);
  const known = bundles.shaking.map(({ name }) => name.slice("drive.".length));
  const wrong = Object.keys(parameters).find((name) => !known.includes(name));
  if (wrong !== undefined) throw new Error(`no drive has the parameter ${wrong}`);
  const times = parameters.times ?? [];
  // A change takes two stretches; one more lies before all of them, and one behind.
  const stretches = kernels.take("stretch", 2 * (Array.isArray(times) ? times.length : 1) + 2);
  const number = kernels.take("i8", 1);
  /** @type {Record<string, Held | number>} */
  const values = { stretches, number };
  for (const { name, dimensions } of bundles.shaking) {
    if (name in values) continue;
    const value = parameters[name.slice("drive.".length)];
    const usual = name === "drive.side" ? BELOW : 0;
    values[name] = dimensions === undefined ? Number(value ?? usual) : kernels.copy(Array.isArray(value) ? value : []);
  }
  values["drive.kind"] = drives.indexOf(kind);
  kernels.call("shake", "shaking", values);
  return { ...stretches, shape: [Number(kernels.numbers(number)[0])] };
}

/**
 * Return the record of a run at time zero, the fastest angular frequency of its drive [rad/s], and
 * what is wrong with its parameters: one of the layout's problems, "fine" if nothing is.
 * @param {Kernels} kernels of the module `one` or `two`
 * @param {Record<string, number | number[]>} parameters fields of the record `case` by their paths,
 *   such as `balls.0.mass`; others are zero, an offset and bounds of the drive not given
 * @param {Held} stretches of the drive
 */
export function begin(kernels, parameters, stretches) {
  const run = kernels.take("run", 1);
  const number = kernels.take("i8", 1);
  const record = kernels.take("case", 1);
  for (const [path, value] of Object.entries({ ...ABSENT, ...parameters })) {
    kernels.set(record, path, ...[value].flat());
  }
  kernels.call("begin", "beginning", { case: record, stretches, run, problem: number });
  const problem = kernels.layout.problems[Number(kernels.numbers(number)[0])];
  return { run, problem, driveRate: kernels.get(record, "drive_rate") };
}
