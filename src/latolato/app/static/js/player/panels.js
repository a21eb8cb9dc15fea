/** What the curves of a run show: angles, energies, powers. */

import { t } from "../strings.js";
import { wrap } from "./motion.js";
import { scaled } from "./traces.js";
import { DEGREE } from "../page/unit_text.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./curves.js").Panel} Panel */
/** @typedef {import("./curves.js").Curve} Curve */

// The pivot's height is shown as in pictures and files, in `shown_unit` of `latolato.core.quantities`.
const HEIGHT = { unit: "mm", size: 1e-3 }; // m
const LENGTH = { unit: "cm", size: 1e-2 }; // m

/**
 * Return the panel of angles.
 * @param {{wrapped?: boolean, pivot?: boolean}} [how] angles within (-180°, 180°], and the pivot's
 *   height beside them
 * @returns {Panel}
 */
export function anglePanel({ wrapped = false, pivot = false } = {}) {
  return {
    label: t("curveAngle"),
    quantity: "angle",
    curves: (motion) => [
      ...motion.balls.map((ball, k) => {
        const values = scaled(motion.values("angle", ball.row) ?? [], ball.sign / DEGREE);
        return {
          label: motion.balls.length > 1 ? t(ball.name) : t("angle"),
          paint: ball.name === "left" ? "left" : "right",
          values: wrapped ? values.map(wrap) : values,
          turn: wrapped ? 360 : undefined,
          ofPose: (/** @type {import("./motion.js").Pose} */ { balls }) => {
            const angle = balls[k].angle / DEGREE;
            return wrapped ? wrap(angle) : angle;
          },
        };
      }),
      ...(pivot ? [pivotCurve(motion)] : []),
    ],
  };
}

/**
 * Return the pivot's height as a curve with an axis of its own.
 * @param {Motion} motion
 * @returns {Curve}
 */
function pivotCurve(motion) {
  const { unit, size } = HEIGHT;
  return { label: t("pivotIn", { unit }), paint: "force", axis: "right",
    values: scaled(motion.values("pivot_height") ?? [], 1 / size) };
}

/** @type {Panel[]} */
export const ENERGY_PANELS = [
  {
    label: (motion) => t("curveEnergy", { whose: whose(motion) }),
    quantity: "energy",
    curves: (motion) => [
      { label: t("kinetic"), paint: "kinetic", values: summed(motion, "kinetic_energy") },
      { label: t("potential"), paint: "potential", values: summed(motion, "potential_energy") },
      { label: t("total"), paint: "ink", values: summed(motion, "total_energy") },
    ],
  },
  {
    label: (motion) => t("curvePower", { whose: whose(motion) }),
    quantity: "power",
    height: 140,
    curves: (motion) => [
      { label: t("drivePower"), paint: "gain", values: summed(motion, "drive_power") },
      { label: t("dampingPower"), paint: "loss", values: summed(motion, "damping_power") },
    ],
  },
];

/** How far balls on strings are from the hand. @type {Panel} */
export const DISTANCE_PANEL = {
  label: t("curveDistance", { unit: LENGTH.unit }),
  height: 140,
  curves: (motion) => motion.balls.filter(({ row }, i) => i === 0 || row > 0).map((ball) => ({
    label: motion.balls.some(({ row }) => row > 0) ? t(ball.name) : t("distance"),
    paint: ball.name === "left" ? "left" : "right",
    values: scaled(motion.values("distance", ball.row) ?? [], 1 / LENGTH.size),
  })),
};

/**
 * Return of how many balls an energy is.
 * @param {{balls: any[]}} motion
 */
export function whose({ balls }) {
  return t(balls.length > 1 ? "bothBalls" : "perBall");
}

/**
 * Return a quantity of all balls on show together: a mirrored ball counts as much as its twin.
 * @param {Motion} motion
 * @param {string} name
 */
export function summed(motion, name) {
  const rows = motion.balls.map((ball) => motion.values(name, ball.row));
  const sum = new Float64Array(motion.time.length);
  for (const values of rows)
    if (values) for (let i = 0; i < sum.length; i += 1) sum[i] += values[i];
  return sum;
}
