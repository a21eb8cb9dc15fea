/** A map as points for the kernels, and their order from coarse to fine; see `latolato.sweeps`. */

/**
 * @typedef {import("../kernels/memory.js").Layout} Layout
 * @typedef {import("../kernels/map.js").MapPoints} MapPoints
 * @typedef {{name: string, values: ArrayLike<number>}} PlanAxis
 *
 * A map [SI]: cells are numbered row by row, x first. Nothing is checked against the ranges that
 * parameters have.
 * @typedef {object} Plan
 * @property {1 | 2} [angles] of the state, 1 if it is left out
 * @property {boolean} [in_plane] whether any point needs the engine for motions in the plane
 * @property {string} drive its kind, such as `harmonic`
 * @property {Record<string, number | number[]>} parameters of the system, the drive, the start and
 *   the noise by the names that axes of sweeps have, such as `length`, `left_mass`,
 *   `initial_angle_right` or `frequency_ratio`; `tolerance`, `rest_speed`, `meets` and other fields
 *   of the record `case`
 * @property {PlanAxis} x
 * @property {PlanAxis} y
 * @property {MapPoints["observables"]} observables
 * @property {number} duration [s]
 * @property {number} [transient] [s]
 * @property {number} [transient_periods] of the drive, of the swing without a drive; on top of it
 * @property {MapPoints["contact"]} [contact]
 * @property {number} [contact_limit]
 *
 * What a picture shows of each point: one number, of a ball where each has its own.
 * @typedef {{name: string, ball: 0 | 1 | null}} PlanVariable
 */

/** @typedef {number | Float64Array} PlanColumn */

// The coarsest picture has about so many cells along its longer side.
const COARSEST = 12;
const SIDES = ["right", "left"];
// Differences of decimal times are rounded by so much, relatively.
const ROUNDING = 1e-12;
const START = ["initial_angle", "initial_angular_velocity", "initial_distance"];

/**
 * Return cells from coarse to fine, with the stride of the level of each: a level has every cell
 * whose row and column are multiples of its stride, a power of two.
 * @param {number} width
 * @param {number} height
 * @returns {{cells: Int32Array, strides: Uint8Array}}
 */
export function inOrder(width, height) {
  let coarsest = 1;
  while (Math.max(width, height) / coarsest > 2 * COARSEST) coarsest *= 2;
  const cells = new Int32Array(width * height);
  const strides = new Uint8Array(width * height);
  let size = 0;
  for (let stride = coarsest; stride >= 1; stride /= 2) {
    for (let row = 0; row < height; row += stride) {
      const isKnown = stride < coarsest && row % (2 * stride) === 0;
      const [first, step] = isKnown ? [stride, 2 * stride] : [0, stride];
      for (let column = first; column < width; column += step, size += 1) {
        cells[size] = row * width + column;
        strides[size] = stride;
      }
    }
  }
  return { cells, strides };
}

/**
 * Return some cells of a map as the points that `computeMap` computes.
 * @param {Layout} layout
 * @param {Plan} plan
 * @param {ArrayLike<number>} cells
 * @returns {MapPoints}
 */
export function pointsOf(layout, plan, cells) {
  const { angles = 1, in_plane, drive, x, y, observables, duration, contact, contact_limit } = plan;
  const count = cells.length;
  const columns = parametersOf(plan, cells);
  /** @type {Record<string, any>} */
  const parameters = {};
  /** @type {Record<string, any>} */
  const shaken = {};
  /** @type {Record<string, any>} */
  const noise = {};
  const isOfDrive = new Set(layout.bundles.shaking.map(({ name }) => name));
  for (const [name, column] of Object.entries(columns)) {
    const path = fieldOf(layout, name, angles);
    if (path) parameters[path] = column;
    else if (isOfDrive.has(`drive.${name}`)) shaken[name] = column;
    else if (name.startsWith("noise_")) noise[name] = column;
    else throw new Error(`no map has the parameter ${name}`);
  }
  if ("noise_strength" in noise && ![x, y].some(({ name }) => /^noise_(seed|stream)$/.test(name))) {
    noise.noise_stream = Float64Array.from(cells, (cell) => (noise.noise_stream ?? 0) + cell);
  }
  const { drive_frequency = 0 } = columns;
  const period = each(count, [drive_frequency], (frequency) => (2 * Math.PI) / frequency);
  const { transient = 0, transient_periods = 0 } = plan;
  const swing = [columns[angles === 1 ? "length" : "right_length"], columns.gravity];
  return { count, angles, in_plane, parameters, drive: { kind: drive, parameters: shaken }, observables,
    duration, contact, contact_limit, period, impossible: impossibleOf(layout, plan, columns, count),
    noise: "noise_strength" in noise ? /** @type {any} */ (noise) : undefined,
    transient: each(count, [period, ...swing], (one, length, gravity) => transient
      + transient_periods * (Number.isFinite(one) ? one : 2 * Math.PI * Math.sqrt(length / gravity))) };
}

/**
 * Return every parameter of some cells, those resolved that stand for others.
 * @param {Plan} plan
 * @param {ArrayLike<number>} cells
 */
function parametersOf({ angles = 1, parameters, x, y }, cells) {
  /** @type {Record<string, any>} */
  const columns = { ...parameters };
  const width = x.values.length;
  columns[x.name] = Float64Array.from(cells, (cell) => x.values[cell % width]);
  columns[y.name] = Float64Array.from(cells, (cell) => y.values[Math.floor(cell / width)]);
  const { gravity, [angles === 1 ? "length" : "right_length"]: length } = columns;
  const { frequency_ratio, amplitude_ratio, drive_acceleration_ratio, ...others } = columns;
  /** @type {(names: PlanColumn[], formula: (...numbers: number[]) => number) => PlanColumn} */
  const made = (from, formula) => each(cells.length, from, formula);
  if (frequency_ratio !== undefined) {
    others.drive_frequency = made([frequency_ratio, gravity, length],
      (ratio, g, l) => ratio * Math.sqrt(g / l));
  }
  if (amplitude_ratio !== undefined) {
    others.drive_amplitude = made([amplitude_ratio, length], (ratio, l) => ratio * l);
  }
  if (drive_acceleration_ratio !== undefined) {
    others.drive_amplitude = made([drive_acceleration_ratio, gravity, others.drive_frequency],
      (ratio, g, frequency) => (ratio * g) / frequency ** 2);
  }
  return others;
}

/**
 * Return which cells have a drive that no number describes, or that contradicts itself.
 * @param {Layout} layout
 * @param {Plan} plan
 * @param {Record<string, any>} columns
 * @param {number} count
 */
function impossibleOf({ largest, drives }, { drive }, columns, count) {
  const limit = drives.find(({ name }) => name === drive)?.amplitude_limit;
  const value = (/** @type {string} */ name, /** @type {number} */ k) =>
    (typeof columns[name] === "object" ? columns[name][k] : columns[name] ?? 0);
  const { times = [] } = columns;
  const gaps = times.slice(1).map((/** @type {number} */ time, /** @type {number} */ i) => time - times[i]);
  const shortest = Math.min(Infinity, ...gaps) * (1 + ROUNDING);
  return Uint8Array.from({ length: count }, (_, k) => {
    const amplitude = value("drive_amplitude", k);
    const isTooLarge = limit && !(amplitude < value(limit[0], k));
    const isOver = !(amplitude <= largest && value("drive_frequency", k) <= largest);
    return Number(isTooLarge || isOver || (gaps.length > 0 && value("ramp", k) > shortest));
  });
}

/**
 * Return a number made of others, for all cells or one for each.
 * @param {number} count
 * @param {PlanColumn[]} columns
 * @param {(...numbers: number[]) => number} formula
 * @returns {PlanColumn}
 */
function each(count, columns, formula) {
  if (columns.every((column) => typeof column === "number")) return formula(...columns);
  return Float64Array.from({ length: count }, (_, k) =>
    formula(...columns.map((column) => (typeof column === "number" ? column : column[k]))));
}

/**
 * Return the field of the record `case` that a parameter of the system or of the start is, if any.
 * @param {Layout} layout
 * @param {string} name
 * @param {number} angles
 */
function fieldOf({ records }, name, angles) {
  if (angles === 1 && START.includes(name)) return `${name}.0`;
  if (angles === 1 && name in records.ball.fields) return `balls.0.${name}`;
  for (const [i, side] of SIDES.slice(0, angles === 1 ? 0 : 2).entries()) {
    const ofBall = name.startsWith(`${side}_`) ? name.slice(side.length + 1) : "";
    if (ofBall in records.ball.fields) return `balls.${i}.${ofBall}`;
    const ofStart = START.find((each) => name === `${each}_${side}`);
    if (ofStart) return `${ofStart}.${i}`;
  }
  return name.split(".")[0] in records.case.fields ? name : null;
}

/**
 * The variables that pictures of a map may show: of exponents the first, of samples none.
 * @param {Layout} layout
 * @param {Pick<Plan, "observables" | "angles">} plan
 * @returns {PlanVariable[]}
 */
export function variablesOf(layout, { observables, angles = 1 }) {
  return observables.flatMap(({ name }) => {
    const { dimension, plain, joint, widths } = layout.observables[name];
    const names = Object.keys(widths).filter((each) => dimension !== "sample" || plain.includes(each));
    /** @type {PlanVariable["ball"][]} */
    const balls = angles === 1 || joint ? [null] : [0, 1];
    return names.flatMap((each) => balls.map((ball) => ({ name: each, ball })));
  });
}
