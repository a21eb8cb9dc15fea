/** The picture of a toy, to scale: the hand that holds the pivot, rods, balls, and what they do. */

import { coloursOf, el, fitCanvas } from "../page/dom.js";
import { contactPoint, drawTrails, Flashes, strengthOf } from "./afterglow.js";
import { drawAngle, drawHangers, drawLines } from "./hang.js";
import { before } from "./motion.js";
import { drawArm, drawFist, drawMover, fistSize, handBox, moverBox } from "./pivot.js";
import { boxAbout, fitScale, joined, place } from "./canvas.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./canvas.js").Scale} Scale */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {import("./hang.js").LedBall} LedBall */

// Kinds of contact up to this one are impacts.
const TOP = 1;
// Smaller balls are drawn this large [pixels of the page].
const LEAST_RADIUS = 4;
// A flash goes on while the run stands still; another picture comes before that when it plays.
const NEXT_FLASH = 40; // ms
const NAMES = ["ink", "soft", "line", "card", "right", "left", "flash", "force", "speed", "skin",
  "skin-line", "sleeve"];

export class Scene {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Motion | null} */
    this.motion = null;
    this.time = 0;
    /** What draws arrows, while they are on show. @type {typeof import("./arrows.js") | null} */
    this.arrows = null;
    /** What the arrows mean; it stands where the page puts it. */
    this.legend = el("ul", { class: "legend of-arrows", hidden: true });
    this.flashes = new Flashes();
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    /** @type {Motion | null} a run that is drawn behind, in outline */
    this.pinned = null;
    /** Balls that a pointer leads, drawn in place of the run. @type {LedBall | null} */
    this.held = null;
    /** Where the balls were last drawn, in pixels of the canvas. */
    this.drawn = /** @type {{x: number, y: number}[]} */ ([]);
    /** @type {Record<string, string>} */
    this.colours = {};
    this.fist = 0;
    /** The greatest speed of the balls [m/s], once arrows ask for it. */
    this.fastest = 0;
    this.release = fitCanvas(canvas, () => this.draw());
  }

  /** @param {Motion} motion */
  show(motion) {
    this.motion = motion;
    this.held = null;
    this.fist = fistSize(motion.balls.map((ball) => ({ ...ball, radius: motion.radius(ball) })));
    this.fastest = 0;
    this.showLegend();
    this.draw();
  }

  /**
   * Show arrows and what they mean, or neither.
   * @param {typeof import("./arrows.js") | null} arrows what draws them
   */
  showArrows(arrows) {
    this.arrows = arrows;
    this.showLegend();
    this.draw();
  }

  showLegend() {
    this.legend.hidden = !this.arrows;
    if (this.arrows && this.motion) this.legend.replaceChildren(...this.arrows.legendOf(this.motion));
  }

  /**
   * Draw an instant; the last clack since the one before flashes.
   * @param {number} time
   */
  move(time) {
    const { motion } = this;
    if (motion?.contacts.length && time > this.time && time - this.time < 1) {
      for (let k = before(motion.contacts, time); motion.contacts[k] > this.time; k -= 1) {
        if (motion.contacts[k] > time || motion.block.arrays.contact_kind[k] > TOP) continue;
        this.flash(motion.pose(motion.contacts[k]), motion.closingSpeed(k));
        break;
      }
    }
    this.time = time;
    this.draw();
  }

  /**
   * Show the flash of a clack.
   * @param {Pose} pose of the balls that meet
   * @param {number} speed at which they do [rad/s]
   */
  flash({ balls }, speed) {
    const { motion } = this;
    if (!motion || balls.length < 2) return;
    this.flashes.add(contactPoint(balls, (ball) => motion.radius(ball)),
      strengthOf(speed, motion.naturalFrequency));
  }

  /** Return the box of all that is drawn about now: the motions, the hand and what moves it [m]. */
  frame() {
    const { motion, arrows, time } = this;
    if (!motion) return { left: -1, right: 1, low: -1, high: 1 };
    const box = motion.box(time);
    const [low, high] = motion.pivotRange;
    const hand = handBox(this.fist);
    const [left, right] = motion.acrossRange;
    return joined([{ ...box, low: box.low - (arrows ? arrows.ROOM * motion.longest : 0) },
      { left: left + hand.left, right: right + hand.right, low: low + hand.low, high: high + hand.high },
      moverBox(motion, arrows !== null), this.pinned?.box(time),
      ...(this.held?.balls ?? []).map(({ ball, x, y }) => boxAbout(x, y, motion.radius(ball))),
    ].filter((each) => each !== null && each !== undefined));
  }

  /**
   * Return how many pixels of a canvas of this size a metre is, and where the origin lies.
   * @param {number} [width] in pixels
   * @param {number} [height]
   * @param {number} [ratio] pixels for one of the page
   */
  scale(width = this.canvas.width, height = this.canvas.height, ratio = window.devicePixelRatio || 1) {
    return fitScale(this.frame(), width, height, ratio);
  }

  /**
   * The position on the canvas of a point of the plane, in the canvas's own pixels.
   * @param {number} x
   * @param {number} y
   */
  place(x, y) {
    return place(this.scale(), x, y);
  }

  /** The pose of pivot and balls on show. */
  pose() {
    return this.held ?? this.motion?.pose(this.time) ?? null;
  }

  draw() {
    const { canvas } = this;
    clearTimeout(this.timer);
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, canvas.width, canvas.height);
    this.colours = coloursOf(NAMES, canvas);
    const pose = this.pose();
    // A canvas that is not in the page has no colours.
    if (!this.colours.ink || !pose) return;
    const scale = this.scale();
    this.drawn = placed(scale, pose);
    if (this.paint({ context, scale, colours: this.colours })) this.timer = setTimeout(() => this.draw(), NEXT_FLASH);
  }

  /**
   * Draw everything, the hand's arm at the back and the balls before the fist: it never hides one.
   * Returns whether something flashes.
   * @param {import("./canvas.js").Drawing} drawing
   */
  paint(drawing) {
    const { motion, arrows, time, fist } = this;
    const { context, scale, colours } = drawing;
    const pose = this.pose();
    if (!motion || !pose) return false;
    const { size, ratio } = scale;
    context.lineCap = context.lineJoin = "round";
    if (this.pinned && time <= this.pinned.end) this.paintPinned(drawing, this.pinned);
    drawMover(drawing, motion, time, arrows !== null);
    drawArm(drawing, pose, fist);
    if (!this.held) drawTrails(drawing, motion, time);
    const balls = placed(scale, pose);
    drawHangers(drawing, pose, motion);
    drawFist(drawing, pose, fist);
    context.strokeStyle = colours.ink;
    context.lineWidth = ratio;
    pose.balls.forEach(({ ball }, i) => {
      const radius = Math.max(motion.radius(ball) * size, LEAST_RADIUS * ratio);
      context.beginPath();
      context.arc(balls[i].x, balls[i].y, radius, 0, 2 * Math.PI);
      context.fillStyle = ball.name === "left" ? colours.left : colours.right;
      context.fill();
      context.stroke();
    });
    if (this.held) {
      drawAngle(drawing, this.held, motion);
      return false;
    }
    if (arrows) {
      // The fastest ball of a motion that grows may be yet to come.
      if (motion.grows || !this.fastest) this.fastest = arrows.topSpeed(motion);
      arrows.drawArrows(drawing, arrows.arrowsAt(motion, time, this.fastest));
    }
    return this.flashes.draw(drawing, motion.longest * size);
  }

  /**
   * Draw a pinned run in outline.
   * @param {import("./canvas.js").Drawing} drawing
   * @param {Motion} motion
   */
  paintPinned(drawing, motion) {
    const { context, scale, colours } = drawing;
    const pose = motion.pose(this.time);
    context.strokeStyle = colours.soft;
    context.lineWidth = 1.2 * scale.ratio;
    context.setLineDash([5 * scale.ratio, 4 * scale.ratio]);
    drawLines(drawing, pose);
    for (const { ball, x, y } of pose.balls) {
      const [bx, by] = place(scale, x, y);
      context.beginPath();
      context.arc(bx, by, motion.radius(ball) * scale.size, 0, 2 * Math.PI);
      context.stroke();
    }
    context.setLineDash([]);
  }
}

/**
 * The positions of a pose's balls, in pixels.
 * @param {Scale} scale
 * @param {Pose} pose
 */
function placed(scale, { balls }) {
  return balls.map((ball) => {
    const [x, y] = place(scale, ball.x, ball.y);
    return { x, y };
  });
}
