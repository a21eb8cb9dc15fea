/**
 * The playhead of a chart: a line at the instant on show, its values in the legend, and dots where
 * balls are led; and the pointer that moves it.
 */

import { el } from "../page/dom.js";
import { valueAt } from "./traces.js";
import { localShort } from "../page/unit_text.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {import("./traces.js").Curve} Curve */

// Numbers that are behind by more than this share of a swing are not shown: what swings is another by then.
const BEHIND = 0.01;

export class Playhead {
  /** @param {Curve[]} curves of the chart, of any run */
  constructor(curves) {
    this.line = el("div", { class: "playhead" });
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
    this.line.style.visibility = isInside ? "visible" : "hidden";
    if (isInside) this.line.style.transform = `translateX(${across}px)`;
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
   * Write the values into the legend, but for those that would be behind the picture.
   * @param {Motion} motion
   * @param {Curve[]} curves
   * @param {number} time
   * @param {Pose | null} held
   * @param {number} lag how far they may be behind [s]
   */
  read(motion, curves, time, held, lag) {
    const period = (2 * Math.PI) / motion.naturalFrequency || 1;
    curves.forEach(({ ofPose, values }, k) => {
      const value = ofPose ? ofPose(held ?? motion.pose(time)) : valueAt(motion.time, values, time);
      const text = lag > BEHIND * period ? "" : localShort(value, 4);
      if (this.values[k].textContent !== text) this.values[k].textContent = text;
    });
  }
}

/**
 * Let a pointer over a chart move the clock, which rests meanwhile.
 * @param {any} plot
 * @param {import("./clock.js").Clock} clock
 */
export function followPointer(plot, clock) {
  const { over } = plot;
  let wasPlaying = false;
  const seek = (/** @type {PointerEvent} */ event) =>
    clock.seek(plot.posToVal(event.clientX - over.getBoundingClientRect().left, "x"));
  over.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
    if (event.button || event.shiftKey) return;
    over.setPointerCapture(event.pointerId);
    wasPlaying = clock.playing;
    clock.pause();
    seek(event);
  });
  over.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    if (over.hasPointerCapture(event.pointerId)) seek(event);
  });
  over.addEventListener("lostpointercapture", () => {
    if (wasPlaying) clock.play();
  });
}
