/** The strip below the stage: the angles over time, and the slider of the instant on the same axis. */

import { t } from "../strings.js";
import { Curves } from "./curves.js";
import { el } from "../page/dom.js";
import { range, wrap } from "./motion.js";
import { scaled } from "./traces.js";
import { DEGREE } from "../page/unit_text.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./clock.js").Clock} Clock */
/** @typedef {import("./curves.js").Panel} Panel */
/** @typedef {import("./curves.js").Curve} Curve */

// The height of the curve is this share of the window's, within limits [pixels].
const SHARE = 0.16;
const LEAST = 64;
const MOST = 190;
// The slider moves in so many steps over the stretch on show.
const STEPS = 1000;
const HALF_TURN = Math.PI;
// The pivot's height is shown as in pictures and files, in `shown_unit` of `latolato.core.quantities`.
const HEIGHT = { unit: "mm", size: 1e-3 }; // m

export class Timeline {
  /** @param {Clock} clock */
  constructor(clock) {
    this.clock = clock;
    const place = el("div", { class: "curves" });
    this.scrub = el("input", { type: "range", min: "0", max: String(STEPS), step: "1", value: "0",
      class: "scrub", "aria-label": t("scrub"), on: {
        input: () => this.seek(Number(this.scrub.value) / STEPS),
        keydown: (/** @type {KeyboardEvent} */ event) => this.key(event),
      } });
    const toggle = (/** @type {string} */ text, /** @type {string} */ hint, /** @type {() => void} */ click) =>
      el("button", { type: "button", class: "plain toggle", title: t(hint), "aria-pressed": "false",
        on: { click } }, t(text));
    this.whole = toggle("wholeRun", "wholeRunHint", () => this.toggleWhole());
    this.wrapped = toggle("wrapAngles", "wrapAnglesHint", () => this.press(this.wrapped));
    this.pivot = toggle("pivotCurve", "pivotCurveHint", () => this.press(this.pivot));
    // Which of them a run needs is known when it comes.
    this.whole.hidden = this.wrapped.hidden = true;
    this.toggles = el("span", { class: "toggles" }, this.whole, this.wrapped, this.pivot);
    this.root = el("div", { class: "timeline" }, place, this.scrub);
    this.curves = new Curves(place, clock, [this.panel()], { follows: true });
    this.curves.onLayout = () => this.align();
  }

  panel() {
    return { ...anglePanel({ wrapped: isPressed(this.wrapped), pivot: isPressed(this.pivot) }),
      height: () => Math.round(Math.min(Math.max(SHARE * window.innerHeight, LEAST), MOST)) };
  }

  /**
   * Show a run.
   * @param {Motion} motion
   * @param {Motion | null} pinned
   */
  show(motion, pinned) {
    this.wrapped.hidden = !motion.balls.some(({ row }) =>
      range(motion.values("angle", row) ?? []).some((angle) => Math.abs(angle) > HALF_TURN));
    this.curves.panels = [this.panel()];
    this.curves.show(motion, pinned);
    this.move(this.clock.time);
  }

  /** @param {HTMLElement} button */
  press(button) {
    button.setAttribute("aria-pressed", String(!isPressed(button)));
    const { motion, pinned } = this.curves;
    if (motion) this.show(motion, pinned);
  }

  /** Show the whole run, or follow the clock again. */
  toggleWhole() {
    if (this.curves.isWhole) this.curves.follow();
    else this.curves.zoom(0, this.clock.end);
  }

  /** Show whether the whole run is seen; of a short one it always is. */
  mark() {
    const { isWhole, readable } = this.curves;
    this.whole.hidden = isWhole && readable >= this.clock.end;
    if (isPressed(this.whole) !== isWhole) this.whole.setAttribute("aria-pressed", String(isWhole));
  }

  /** Put the slider under the part of the curve that it stands for. */
  align() {
    const over = this.curves.charts[0].plot.over.getBoundingClientRect();
    this.scrub.style.setProperty("--from", `${over.left - this.root.getBoundingClientRect().left}px`);
    this.scrub.style.setProperty("--across", `${over.width}px`);
  }

  /** @param {number} share of the stretch on show */
  seek(share) {
    const [from, to] = this.curves.span;
    this.clock.seek(from + share * (to - from));
  }

  /**
   * Go to the ends of the run, not of what is on show.
   * @param {KeyboardEvent} event
   */
  key(event) {
    const time = { Home: 0, End: this.clock.end }[event.key];
    if (time === undefined) return;
    event.preventDefault();
    this.clock.seek(time);
  }

  /**
   * Move the slider to an instant.
   * @param {number} time
   */
  move(time) {
    const [from, to] = this.curves.span;
    this.scrub.value = String(Math.round((STEPS * (time - from)) / (to - from || 1)));
  }

  /**
   * Say where the slider stands.
   * @param {number} time
   */
  update(time) {
    if (this.curves.motion?.grows) return;
    this.scrub.setAttribute("aria-valuetext", t("instantOf", { time: time.toFixed(2), end: this.clock.end }));
  }
}

/** @param {HTMLElement | undefined} button */
function isPressed(button) {
  return button?.getAttribute("aria-pressed") === "true";
}

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
