/** Points of a map in lanes or one by one, as `latolato.sweeps.batches`. */

/**
 * @typedef {import("./memory.js").HeldMemory} HeldMemory
 * @typedef {import("./memory.js").Kernels} Kernels
 */

/**
 * Points of a map: what they are by the names of `many.Points`, with which of them run and in which
 * order; where their progress goes, by those of `many.Progress`; the stepper's weights.
 * @typedef {{order: HeldMemory, points: Record<string, HeldMemory | number>, progress: Record<string, HeldMemory>,
 *   stepper: {kicks: HeldMemory, drifts: HeldMemory, nodes: HeldMemory}, slots: number, is_linear: boolean,
 *   engine?: "engine" | "clamp"}} Points
 */

/**
 * Run points.
 *
 * @param {Kernels} kernels of the module that `moduleOf` in `map.js` names
 * @param {Points} batch
 * @param {[number, string][][]} callbacks what observables are shown on each occasion: pairs of first
 *   slot and kernel
 * @param {{walled: boolean, shown: [number, string][][], needs: string[]} | null} lanes whether there
 *   are walls, what shows the observables all lanes' steps, and matrices, and what they need of each
 *   step; null runs one point after the other,
 *   as all must that `latolato.sweeps.batches.has_lanes` excludes
 */
export function runPoints(kernels, batch, callbacks, lanes) {
  const { layout } = kernels;
  const { order, stepper, slots, is_linear, engine = "engine" } = batch;
  const size = layout.scratch_contacts;
  const runs = kernels.take("run", 1);
  const stages = stepper.drifts.shape[0];
  kernels.set(runs, "stages", stages);
  for (const name of /** @type {("kicks" | "drifts" | "nodes")[]} */ (["kicks", "drifts", "nodes"])) {
    kernels.set(runs, name, ...kernels.numbers(stepper[name]));
  }
  kernels.set(runs, "settings.is_linear", Number(is_linear));
  kernels.set(runs, "engine", kernels.addresses[engine]);
  kernels.set(runs, "callbacks", kernels.callbacks(callbacks).at);
  const job = {
    order, cancel: kernels.take("i8", 1),
    ...named("points", batch.points), ...named("progress", batch.progress),
    "scratch.runs": runs, "scratch.contact_times": kernels.take("f8", size),
    "scratch.contact_kinds": kernels.take("i8", size),
    "scratch.contact_values": kernels.take("f8", layout.contact_rows.count, size),
    "scratch.no_times": kernels.take("f8", 0),
    "scratch.no_samples": kernels.take("f8", kernels.rows.samples, 0),
  };
  if (lanes === null) {
    kernels.call("batch", "job", job);
  } else {
    const space = laneSpace(kernels, stages, slots, is_linear, lanes);
    kernels.call("lanes", "task", { ...job, ...named("weights", stepper), ...named("space", space) });
  }
  kernels.release(runs);
}

/**
 * Return the memory of lanes and their kernels; see `batch.make_lane_space`.
 * @param {Kernels} kernels
 * @param {number} stages
 * @param {number} slots
 * @param {boolean} is_linear
 * @param {{walled: boolean, shown: [number, string][][], needs: string[]}} lanes
 */
function laneSpace(kernels, stages, slots, is_linear, { walled, shown, needs }) {
  const { lanes, rows, table_rows, impacts, impact_rows } = kernels.layout.lanes;
  const law = is_linear ? "restoring_linear" : "restoring_sine";
  const [steps, matrices] = shown;
  /** @type {[number, string][]} */
  const shared = needs.length ? [[0, "shared_values_energy_turn"]] : [];
  const step = `lane_step_${law}${walled ? "_walled" : ""}${matrices.length ? "_tangents" : ""}`;
  const point = kernels.take("i8", lanes);
  kernels.numbers(point).fill(-1n);
  return {
    w: kernels.take("f8", rows * lanes), z: kernels.take("f8", impact_rows * impacts),
    table: kernels.take("f8", (stages + 1) * table_rows * lanes),
    acc: kernels.take("f8", lanes * slots), point, index: kernels.take("i8", lanes),
    lane: kernels.take("i8", impacts), step: kernels.addresses[step],
    locate: walled ? kernels.addresses[`lane_locate_${law}`] : 0, callbacks: kernels.callbacks([[...shared, ...steps], matrices]),
  };
}

/**
 * Return values with their names behind that of a tuple.
 * @param {string} tuple
 * @param {Record<string, HeldMemory | number>} values
 */
function named(tuple, values) {
  return Object.fromEntries(Object.entries(values).map(([name, value]) => [`${tuple}.${name}`, value]));
}
