/** Where the balls of a run begin: a pointer or keys lead them there. */

import { t } from "../strings.js";
import { el, isCalm } from "../page/dom.js";
import { followDrag } from "./drag.js";
import { followKeys } from "../page/keys.js";
import { poseOf } from "./motion.js";
import { DEGREE } from "../page/unit_text.js";

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").MotionBall} MotionBall */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {import("../page/keys.js").KeyActions} KeyActions */

// Of the arrow keys, without and with Shift [degrees].
const STEP = 5;
const SMALL_STEP = 1;
// Angles are rounded to this part of a degree.
const PARTS = 10;
// Keys that follow each other faster go on from each other.
const QUICK = 1000; // ms

/**
 * Return the options of a run that begins at rest at other angles.
 * @param {Record<string, string>} options
 * @param {Record<string, any>} resolved what the run on show had, in SI units
 * @param {number[]} degrees of each ball that has an angle of its own
 */
export function withStart(options, resolved, degrees) {
  const { initial_offset: _, ...rest } = options;
  const moves = [resolved.initial_angular_velocity ?? 0].flat().some((speed) => speed !== 0);
  return { ...rest, initial_angle: degrees.map((angle) => `${angle} deg`).join(", "),
    ...(moves ? { initial_angular_velocity: degrees.map(() => "0 rad/s").join(", ") } : {}) };
}

/**
 * Return the limits of the angle of a ball: it goes up to the other one, below and above, and not
 * through it.
 * @param {Motion} motion
 * @param {number[]} degrees of each ball that has an angle of its own
 * @param {number} row of the ball
 * @returns {[number, number]} in degrees
 */
export function angleLimits(motion, degrees, row) {
  const gap = (motion.about.attributes?.contact_separation ?? 0) / DEGREE;
  if (degrees.length === 1)
    return [(motion.low ?? -Infinity) / DEGREE, (motion.high ?? Infinity) / DEGREE];
  const other = degrees[1 - row];
  return row === 0 ? [other + gap, other + 360 - gap] : [other - 360 + gap, other - gap];
}

/**
 * Return an angle in its limits, rounded into them.
 * @param {number} degrees
 * @param {[number, number]} limits
 */
export function rounded(degrees, [low, high]) {
  // Limits that are round already may be off by their last digit.
  const tiny = 1e-9;
  const least = Math.ceil(low * PARTS - tiny);
  const most = Math.floor(high * PARTS + tiny);
  return Math.min(Math.max(Math.round(degrees * PARTS), least), most) / PARTS;
}

/**
 * Return the angles of the balls that have one of their own, in the turn about the bottom.
 * @param {Pose} pose
 * @returns {number[]} in degrees
 */
export function anglesOf({ balls }) {
  const degrees = balls.filter(({ ball }) => ball.sign > 0).map(({ angle }) => angle / DEGREE);
  const middle = degrees.reduce((sum, angle) => sum + angle, 0) / degrees.length;
  return degrees.map((angle) => rounded(angle - 360 * Math.round(middle / 360), [-Infinity, Infinity]));
}

export class Start {
  /**
   * @param {Scene} scene
   * @param {import("./clock.js").Clock} clock
   */
  constructor(scene, clock) {
    this.scene = scene;
    this.clock = clock;
    /** Called with the new angles [degrees]. @type {((degrees: number[]) => void) | null} */
    this.choose = null;
    /** @type {number[]} chosen last, in degrees */
    this.degrees = [];
    /** Ends listening to keys. @type {(() => void) | null} */
    this.release = null;
    this.led = false;
    this.plays = false;
    this.pressed = -Infinity;
    this.said = el("p", { class: "unseen", role: "status" });
    followDrag(scene, { isOn: () => this.choose !== null, grab: () => clock.pause(),
      lead: (ball, angle) => this.lead(ball, angle / DEGREE), drop: () => this.drop() });
    const step = (/** @type {number} */ k, /** @type {number} */ way) =>
      (/** @type {KeyboardEvent} */ event) => this.press(k, way, event.shiftKey);
    const [toLeft, toRight] = [step(1, -1), step(1, 1)];
    /** @type {KeyActions} */
    this.actions = {
      ArrowLeft: { text: "keyStartRight", act: step(0, -1) },
      ArrowRight: { text: "keyStartRight", act: step(0, 1) },
      a: { text: "keyStartLeft", act: toLeft },
      d: { text: "keyStartLeft", act: toRight },
      A: { text: "keyStartLeft", act: toLeft },
      D: { text: "keyStartLeft", act: toRight },
    };
    // Where no run comes of a choice, the one on show goes on.
    clock.subscribe(() => { if (clock.playing) scene.held = null; });
  }

  /**
   * Let people choose where the balls begin.
   * @param {(degrees: number[]) => void} choose
   */
  enable(choose) {
    const { canvas } = this.scene;
    this.release ??= followKeys(canvas, this.actions);
    this.choose = choose;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", t("playStage"));
  }

  /** Leave the balls to who holds the toy. */
  disable() {
    this.choose = null;
    this.release?.();
    this.release = null;
  }

  /**
   * Show a ball at an angle, the others where they are.
   * @param {MotionBall} ball
   * @param {number} angle in degrees
   */
  lead(ball, angle) {
    const pose = this.scene.pose();
    if (!pose) return;
    if (!this.led) this.degrees = anglesOf(pose);
    this.led = true;
    this.hold(ball, angle + 360 * Math.round((this.degrees[ball.row] - angle) / 360));
  }

  /** The ball is let go: the run begins there. */
  drop() {
    if (!this.led) return;
    this.led = false;
    this.plays = !isCalm();
    this.update();
  }

  /** The actions of the keys that move the balls of the run on show. @returns {KeyActions} */
  keys() {
    const count = this.scene.motion?.balls.length ?? 0;
    return Object.fromEntries(Object.entries(this.actions).filter(([key]) => count > 1 || key.startsWith("Arrow")));
  }

  /**
   * Lead a ball by one step.
   * @param {number} k number of the ball
   * @param {number} way -1 to the left, 1 to the right
   * @param {boolean} isSmall whether the step is
   */
  press(k, way, isSmall) {
    const { motion } = this.scene;
    const ball = motion?.balls[k];
    if (!ball || !this.choose) return;
    this.clock.pause();
    // The run of the key before may not be there yet.
    const now = performance.now();
    if (now - this.pressed > QUICK) this.degrees = anglesOf(motion.pose(0));
    this.pressed = now;
    this.plays = false;
    this.hold(ball, this.degrees[ball.row] + ball.sign * way * (isSmall ? SMALL_STEP : STEP));
    this.update();
  }

  /**
   * Show the balls where the run will begin, with the angle of the one that is led.
   * @param {MotionBall} led
   * @param {number} angle in degrees
   */
  hold(led, angle) {
    const { scene, clock } = this;
    const { motion } = scene;
    if (!motion) return;
    const limits = angleLimits(motion, this.degrees, led.row);
    // A ball without limits has been round: only where it is matters.
    const turns = Number.isFinite(limits[0]) ? 0 : Math.ceil(angle / 360 - 0.5);
    const chosen = rounded(angle - 360 * turns, limits);
    this.degrees = this.degrees.map((each, row) => (row === led.row ? chosen : each));
    const pose = poseOf(motion.at("pivot_height", 0), motion.balls,
      ({ row, sign }) => sign * this.degrees[row] * DEGREE,
      motion.at("pivot_across", 0) || 0, (ball) => motion.distance(ball, 0));
    scene.held = { ...pose, led: motion.balls.indexOf(led), text: t("degrees", { angle: chosen }) };
    clock.seek(0);
  }

  /** Say what is chosen, and ask for its run. */
  update() {
    const angle = this.degrees.join(", ");
    const single = (this.scene.motion?.balls.length ?? 0) < 2;
    this.said.textContent = t(single ? "startsAtOne" : "startsAt", { angle });
    this.choose?.(this.degrees);
  }

  /** A run is on show: play it if its ball was let go. */
  play() {
    if (this.plays) this.clock.play();
    this.plays = false;
  }
}
