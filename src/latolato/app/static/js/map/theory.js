/** Amplitudes and frequencies in the coordinates of a map, and the curves of theory over it. */

import { brokenRule } from "../model/rules.js";
import { changeBetween, tongueEdges } from "../model/tongue.js";
import { t } from "../strings.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./overlay_curves.js").Line} Line */
/** @typedef {{amplitude: number, frequency: number}} TheoryDrive in m and rad/s */

const AMPLITUDES = ["drive_amplitude", "amplitude_ratio", "drive_acceleration_ratio"];
const FREQUENCIES = ["drive_frequency", "frequency_ratio"];
// No frequency holds a hanging pendulum in the tongue beyond this amplitude.
const CLOSED = 3.8; // lengths
const SAMPLES = 400;
// A map may begin at frequency zero, where lift-off takes an infinite amplitude.
const SLOWEST = 1e-3; // of the fastest

/** What turns amplitudes and frequencies into the coordinates of a map. */
export class Placing {
  /**
   * @param {Pick<Grid, "x" | "y" | "about">} grid
   * @throws {InputError} if the map is not one of amplitude and frequency, or if its drag is relative to the room
   */
  constructor(grid) {
    const { about, x: { name: x, edges: along }, y: { name: y, edges: up } } = grid;
    if (!(FREQUENCIES.includes(x) && AMPLITUDES.includes(y))
      && !(FREQUENCIES.includes(y) && AMPLITUDES.includes(x)))
      throw brokenRule("overlay_axes", { value: [y, x] },
        { amplitudes: AMPLITUDES.join(", "), frequencies: FREQUENCIES.join(", ") });
    const side = "right_length" in about.parameters ? "right_" : "";
    const number = (/** @type {string} */ name) => {
      const value = about.parameters[name];
      if (typeof value !== "number")
        throw brokenRule("overlay_parameter", { parameter: name });
      return value;
    };
    this.x = x;
    this.y = y;
    this.length = number(`${side}length`);
    this.mass = number(`${side}mass`);
    this.damping = number(`${side}damping`);
    this.gravity = number("gravity");
    if (about.laws.drag_frame === "lab" && this.damping > 0)
      throw brokenRule("overlay_drag", { parameter: "drag_frame", value: "lab" });
    this.hasContact = Boolean(about.has_contact);
    /** @type {Record<string, [number, number]>} */
    this.spans = { [x]: [along[0], along[along.length - 1]], [y]: [up[0], up[up.length - 1]] };
  }

  /** w0 [rad/s]. */
  get naturalFrequency() {
    return Math.sqrt(this.gravity / this.length);
  }

  /**
   * Return the coordinates of a drive.
   * @param {TheoryDrive} drive
   * @returns {[number, number]}
   */
  place({ amplitude, frequency }) {
    /** @type {Record<string, number>} */
    const along = {
      drive_amplitude: amplitude,
      amplitude_ratio: amplitude / this.length,
      drive_acceleration_ratio: amplitude * frequency ** 2 / this.gravity,
      drive_frequency: frequency,
      frequency_ratio: frequency / this.naturalFrequency,
    };
    return [along[this.x], along[this.y]];
  }

  /**
   * Return the drive at values along both axes, or at another frequency.
   * @param {Record<string, number>} values by the names of the axes
   * @param {number} [frequency]
   * @returns {TheoryDrive}
   */
  plain(values, frequency = values.drive_frequency ?? values.frequency_ratio * this.naturalFrequency) {
    const amplitude = values.drive_amplitude
      ?? (values.amplitude_ratio === undefined
        ? values.drive_acceleration_ratio * this.gravity / frequency ** 2
        : values.amplitude_ratio * this.length);
    return { amplitude, frequency };
  }

  /** Return the first or the last values along both axes. @param {0 | 1} end */
  corner(end) {
    return Object.fromEntries(Object.entries(this.spans).map(([name, span]) => [name, span[end]]));
  }

  /** Return the least and the largest frequency of the map [rad/s], above zero. */
  frequencies() {
    const [slow, fast] = /** @type {const} */ ([0, 1]).map((end) => this.plain(this.corner(end)).frequency);
    return [Math.max(slow, SLOWEST * fast), fast];
  }

  /**
   * Return a line through drives.
   * @param {string} name
   * @param {string} label
   * @param {TheoryDrive[]} drives
   * @param {boolean} [isSolid]
   * @returns {Line}
   */
  line(name, label, drives, isSolid = true) {
    const places = drives.map((drive) => this.place(drive));
    return { name, label, colour: "", marks: [], xs: places.map(([x]) => x), ys: places.map(([, y]) => y),
      edges: places.map(() => isSolid) };
  }
}

/**
 * Return both edges of the primary Mathieu tongue as one line from edge to edge around the tip; an
 * upper edge of infinity is left out as NaN.
 * @param {Placing} placing
 * @throws {InputError} if the pendulum does not oscillate
 */
export function tongue(placing) {
  const { length, mass, damping, gravity, naturalFrequency } = placing;
  const zeta = damping / (2 * mass * length * naturalFrequency);
  if (zeta >= 1)
    throw brokenRule("tongue", { parameter: "damping" }, { damping, ratio: zeta });
  const edges = (/** @type {number} */ amplitude) => tongueEdges(2 * amplitude / length, zeta);
  const isClosed = (/** @type {number} */ amplitude) => Number.isNaN(edges(amplitude)[0]);
  const { amplitude: most } = placing.plain(placing.corner(1), placing.frequencies()[0]);
  const largest = Math.min(most, CLOSED * length);
  if (isClosed(largest)) return placing.line("tongue", t("mapTongue"), []);
  const tip = damping > 0 ? changeBetween(isClosed, 0, largest) : 0;
  // Denser near the tip, where a damped tongue is round.
  const amplitudes = evenlyBetween(0, 1, SAMPLES).map((share) => tip + (largest - tip) * share ** 2);
  const sides = amplitudes.map(edges);
  const drives = (/** @type {0 | 1} */ side) => amplitudes.map((amplitude, i) => {
    const ratio = sides[i][side];
    return { amplitude, frequency: Number.isFinite(ratio) ? ratio * naturalFrequency : NaN };
  });
  return placing.line("tongue", t("mapTongue"), [...drives(0).reverse(), ...drives(1)]);
}

/**
 * The line on which the pivot's largest acceleration equals gravity.
 * @param {Placing} placing
 * @throws {InputError} if nothing can rest on a wall
 */
export function liftOff(placing) {
  if (!placing.hasContact)
    throw brokenRule("lift_off");
  const [slow, fast] = placing.frequencies();
  // Even also along a logarithmic axis.
  const frequencies = [...evenlyBetween(slow, fast, SAMPLES),
    ...evenlyBetween(Math.log(slow), Math.log(fast), SAMPLES).map(Math.exp)].sort((a, b) => a - b);
  const drives = frequencies.map((frequency) =>
    ({ amplitude: placing.gravity / frequency ** 2, frequency }));
  return placing.line("lift", t("mapLift"), drives, false);
}

/**
 * @param {number} low
 * @param {number} high
 * @param {number} count
 */
function evenlyBetween(low, high, count) {
  return Array.from({ length: count }, (_, i) => low + (high - low) * (i / (count - 1)));
}
