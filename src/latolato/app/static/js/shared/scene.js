/** The picture of pivot, crank, rods and balls, to scale. */

import { colour, fitCanvas } from "./dom.js";

/** @typedef {import("./motion.js").Motion} Motion */

// Seconds of the page for which a clack flashes.
const FLASH = 0.18;
const MARGIN = 0.1;

export class Scene {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Motion | null} */
    this.motion = null;
    this.time = 0;
    this.arrows = false;
    this.flash = -1;
    this.flashAt = 0;
    /** Who wants little motion sees no flashes. */
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    /** @type {Motion | null} a run that is drawn behind, in outline */
    this.pinned = null;
    /** Where the balls were last drawn, in pixels of the canvas. */
    this.drawn = /** @type {{x: number, y: number}[]} */ ([]);
    this.box = { left: -1, right: 1, low: -1, high: 1 };
    this.colours = this.readColours();
    /** @type {[number, number]} */
    this.pivotRange = [0, 0];
    this.topSpeed = 1;
    this.release = fitCanvas(canvas, () => {
      this.colours = this.readColours();
      this.draw();
    });
  }

  /** Return the colours of the style sheet, read once for each theme. */
  readColours() {
    const read = (/** @type {string} */ name) => colour(name, this.canvas);
    return {
      ink: read("ink"), soft: read("soft"), line: read("line"), right: read("right"),
      left: read("left"), flash: read("flash"), force: read("force"), speed: read("speed"),
    };
  }

  /** @param {Motion} motion */
  show(motion) {
    this.motion = motion;
    this.box = motion.box();
    const { options } = motion.about;
    if (options.drive === "crank_slider") {
      const [, y] = crank(options, 0).center;
      this.box.high = Math.max(this.box.high, y + options.drive_amplitude);
      this.box.low = Math.min(this.box.low, y - options.drive_amplitude);
    }
    this.pivotRange = range(motion.values("pivot_height") ?? [0]);
    this.topSpeed = Math.max(1e-9, ...motion.balls.map((b) =>
      b.length * largest(motion.values("angular_velocity", b.row) ?? [0])));
    this.draw();
  }

  /**
   * Draw an instant; contacts since the last one flash.
   * @param {number} time
   */
  move(time) {
    const contacts = this.motion?.contacts;
    if (contacts?.length && time > this.time && time - this.time < 1) {
      for (let k = contacts.length - 1; k >= 0; k -= 1) {
        if (contacts[k] > time) continue;
        if (contacts[k] > this.time) {
          this.flash = this.motion?.block.arrays.contact_kind[k] ?? -1;
          this.flashAt = performance.now();
        }
        break;
      }
    }
    this.time = time;
    this.draw();
  }

  /** Return how many pixels a metre is, and where the origin lies. */
  scale() {
    const { width, height } = this.canvas;
    const { left, right, low, high } = this.box;
    const reach = Math.max(-left, right, 1e-6);
    const grown = 1 + MARGIN;
    const size = Math.min(width / (2 * reach * grown), height / ((high - low) * grown || 1));
    return { size, x: width / 2, y: height / 2 + (0.5 * (low + high)) * size };
  }

  /**
   * Return where a point of the plane lies on the canvas, in its own pixels.
   * @param {number} x
   * @param {number} y
   * @returns {[number, number]}
   */
  place(x, y) {
    const { size, x: cx, y: cy } = this.scale();
    return [cx + x * size, cy - y * size];
  }

  draw() {
    const { canvas, motion } = this;
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (!motion) return;
    const { size } = this.scale();
    const ratio = window.devicePixelRatio || 1;
    const pose = motion.pose(this.time);
    const unit = motion.longest * size;
    context.lineCap = "round";
    if (this.pinned && this.time <= this.pinned.end) this.drawGhost(context, this.pinned, ratio);
    this.drawDrive(context, pose.height, unit);
    const [px, py] = this.place(0, pose.height);
    this.drawn = [];
    for (const { ball, x, y } of pose.balls) {
      const [bx, by] = this.place(x, y);
      this.drawn.push({ x: bx, y: by });
      context.strokeStyle = this.colours.ink;
      context.lineWidth = Math.max(1.5 * ratio, 0.012 * unit);
      line(context, px, py, bx, by);
      context.beginPath();
      context.arc(bx, by, Math.max(motion.radius(ball) * size, 2 * ratio), 0, 2 * Math.PI);
      context.fillStyle = ball.name === "left" ? this.colours.left : this.colours.right;
      context.fill();
      context.lineWidth = ratio;
      context.stroke();
    }
    context.fillStyle = this.colours.soft;
    context.fillRect(px - 0.05 * unit, py - 0.025 * unit, 0.1 * unit, 0.05 * unit);
    this.drawFlash(context, pose, unit);
    if (this.arrows) this.drawArrows(context, pose, unit);
  }

  /**
   * Draw a pinned run in outline.
   * @param {CanvasRenderingContext2D} context
   * @param {Motion} motion
   * @param {number} ratio
   */
  drawGhost(context, motion, ratio) {
    const { height, balls } = motion.pose(this.time);
    const { size } = this.scale();
    context.strokeStyle = this.colours.soft;
    context.lineWidth = 1.2 * ratio;
    context.setLineDash([5 * ratio, 4 * ratio]);
    for (const { ball, x, y } of balls) {
      const [bx, by] = this.place(x, y);
      line(context, ...this.place(0, height), bx, by);
      context.beginPath();
      context.arc(bx, by, motion.radius(ball) * size, 0, 2 * Math.PI);
      context.stroke();
    }
    context.setLineDash([]);
  }

  /**
   * Draw what moves the pivot: a crank, or a wheel whose pin is level with it, as cosines are.
   * @param {CanvasRenderingContext2D} context
   * @param {number} height of the pivot
   * @param {number} unit longest rod in pixels
   */
  drawDrive(context, height, unit) {
    const [low, high] = this.pivotRange;
    const [x, bottom] = this.place(0, low);
    const [, top] = this.place(0, high);
    context.strokeStyle = this.colours.line;
    context.lineWidth = Math.max(4, 0.03 * unit);
    line(context, x, bottom, x, top);
    const kind = this.motion?.about.options.drive;
    if (!(high > low) || kind === "measured_pivot") return;
    context.lineWidth = Math.max(1, 0.008 * unit);
    if (kind === "crank_slider") {
      const { center, pin } = crank(this.motion?.about.options, this.time);
      this.drawWheel(context, center, pin, unit);
      line(context, ...this.place(...pin), x, this.place(0, height)[1]);
      return;
    }
    const { size } = this.scale();
    const radius = 0.5 * (high - low);
    const middle = 0.5 * (high + low);
    const away = -0.16 * (unit / size) - radius;
    const up = height - middle;
    const rising = (this.motion?.at("pivot_height", this.time + 1e-3) ?? 0) > height;
    const across = Math.sqrt(Math.max(radius * radius - up * up, 0)) * (rising ? -1 : 1);
    this.drawWheel(context, [away, middle], [away + across, height], unit);
    line(context, ...this.place(away + across, height), ...this.place(0, height));
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {[number, number]} center in m
   * @param {[number, number]} pin
   * @param {number} unit
   */
  drawWheel(context, center, pin, unit) {
    const radius = Math.hypot(pin[0] - center[0], pin[1] - center[1]) * this.scale().size;
    context.beginPath();
    context.arc(...this.place(...center), radius, 0, 2 * Math.PI);
    context.stroke();
    context.beginPath();
    context.arc(...this.place(...pin), Math.max(2, 0.014 * unit), 0, 2 * Math.PI);
    context.fillStyle = this.colours.soft;
    context.fill();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {any} pose
   * @param {number} unit
   */
  drawFlash(context, pose, unit) {
    const age = (performance.now() - this.flashAt) / 1000;
    if (this.calm.matches || this.flash < 0 || this.flash > 1 || age > FLASH || pose.balls.length < 2) return;
    const [a, b] = pose.balls;
    const [x, y] = this.place(0.5 * (a.x + b.x), 0.5 * (a.y + b.y));
    context.globalAlpha = 1 - age / FLASH;
    context.strokeStyle = this.colours.flash;
    context.lineWidth = 0.02 * unit;
    for (let k = 0; k < 8; k += 1) {
      const turn = (k * Math.PI) / 4;
      const [c, s] = [Math.cos(turn), Math.sin(turn)];
      line(context, x + 0.07 * unit * c, y + 0.07 * unit * s, x + 0.15 * unit * c, y + 0.15 * unit * s);
    }
    context.globalAlpha = 1;
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {any} pose
   * @param {number} unit
   */
  drawArrows(context, pose, unit) {
    const motion = /** @type {Motion} */ (this.motion);
    const gravity = motion.about.options.gravity;
    for (const { ball, angle, x, y } of pose.balls) {
      const [bx, by] = this.place(x, y);
      const rate = ball.sign * motion.at("angular_velocity", this.time, ball.row);
      const speed = (0.35 * unit * ball.length * rate) / this.topSpeed;
      arrow(context, bx, by, speed * Math.cos(angle), -speed * Math.sin(angle), this.colours.speed);
      const tension = motion.at("tension", this.time, ball.row);
      if (Number.isFinite(tension)) {
        const pull = (0.15 * unit * tension) / (ball.mass * gravity);
        const most = Math.sign(pull) * Math.min(Math.abs(pull), 0.8 * unit);
        arrow(context, bx, by, -most * Math.sin(angle), -most * Math.cos(angle), this.colours.force);
      }
      arrow(context, bx, by, 0, 0.15 * unit, this.colours.force);
    }
  }
}

/**
 * Return the centre of a crank and its pin at an instant [m]; a guide below has the crank above.
 * @param {any} options
 * @param {number} time
 * @returns {{center: [number, number], pin: [number, number]}}
 */
export function crank(options, time) {
  const phase = options.drive_frequency * time + (options.drive_phase ?? 0);
  const y = (options.guide === "above" ? -1 : 1) * options.connecting_rod_length;
  const a = options.drive_amplitude;
  return { center: [0, y], pin: [a * Math.sin(phase), y + a * Math.cos(phase)] };
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x0
 * @param {number} y0
 * @param {number} x1
 * @param {number} y1
 */
function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x
 * @param {number} y
 * @param {number} dx
 * @param {number} dy
 * @param {string} paint
 */
function arrow(context, x, y, dx, dy, paint) {
  const length = Math.hypot(dx, dy);
  if (length < 2) return;
  const ratio = window.devicePixelRatio || 1;
  const head = Math.min(8 * ratio, 0.5 * length);
  const [ux, uy] = [dx / length, dy / length];
  context.strokeStyle = context.fillStyle = paint;
  context.lineWidth = 2.5 * ratio;
  line(context, x, y, x + dx - ux * head, y + dy - uy * head);
  context.beginPath();
  context.moveTo(x + dx, y + dy);
  context.lineTo(x + dx - head * (ux - 0.5 * uy), y + dy - head * (uy + 0.5 * ux));
  context.lineTo(x + dx - head * (ux + 0.5 * uy), y + dy - head * (uy - 0.5 * ux));
  context.fill();
}

/**
 * Return the least and the largest finite value.
 * @param {ArrayLike<number>} values
 * @returns {[number, number]}
 */
export function range(values) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < values.length; i += 1) {
    const value = values[i];
    if (value < low && value > -Infinity) low = value;
    if (value > high && value < Infinity) high = value;
  }
  return low <= high ? [low, high] : [0, 0];
}

/** @param {ArrayLike<number>} values */
function largest(values) {
  const [low, high] = range(values);
  return Math.max(-low, high);
}
