/** What a chart shows of one instant: a line, the values in the legend, and dots where balls are led. */

import { el } from "./dom.js";
import { valueAt } from "./traces.js";
import { localShort } from "./units.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {import("./traces.js").Curve} Curve */

export class Instant {
  /** @param {Curve[]} curves of the chart, of any run */
  constructor(curves) {
    this.head = el("div", { class: "playhead" });
    this.values = curves.map(() => el("output", {}));
    this.dots = curves.map(({ paint }) => el("div", { class: `led fill ${paint}`, hidden: true }));
  }

  /**
   * Put line and dots in their places.
   * @param {any} plot
   * @param {Curve[]} curves
   * @param {number} time
   * @param {Pose | null} held the balls where they are led
   */
  place(plot, curves, time, held) {
    const { min, max } = plot.scales.x;
    const isInside = time >= min && time <= max;
    const across = plot.valToPos(time, "x");
    this.head.style.visibility = isInside ? "visible" : "hidden";
    if (isInside) this.head.style.transform = `translateX(${across}px)`;
    curves.forEach(({ ofPose }, k) => {
      const dot = this.dots[k];
      dot.hidden = !held || !ofPose || !isInside;
      if (!held || !ofPose || !isInside) return;
      // Beyond the axis it waits at its end.
      const down = Math.min(Math.max(plot.valToPos(ofPose(held), "y"), 0), plot.over.clientHeight);
      dot.style.transform = `translate(${across}px, ${down}px)`;
    });
  }

  /**
   * Write the values into the legend.
   * @param {Motion} motion
   * @param {Curve[]} curves
   * @param {number} time
   * @param {Pose | null} held
   */
  read(motion, curves, time, held) {
    curves.forEach(({ ofPose, values }, k) => {
      const value = ofPose ? ofPose(held ?? motion.pose(time)) : valueAt(motion.time, values, time);
      const text = localShort(value, 4);
      if (this.values[k].textContent !== text) this.values[k].textContent = text;
    });
  }
}
