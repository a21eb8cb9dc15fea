/** What the further curves of a run show: energies, powers, and distances of balls on strings. */

import { t } from "../strings.js";
import { scaled } from "./traces.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./curves.js").Panel} Panel */

const LENGTH = { unit: "cm", size: 1e-2 }; // m

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
