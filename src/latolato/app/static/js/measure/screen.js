/** The video with what was found drawn on it, frame by frame. */

import { colour, el, fitCanvas, tick } from "../page/dom.js";
import { followKeys } from "../page/keys.js";
import { speedMenu } from "../player/clock.js";
import { cross, outline } from "../player/canvas.js";
import { DEGREE } from "../page/unit_text.js";
import { t } from "../strings.js";
import { ClipClock } from "./video_clock.js";
import { SIDES } from "./track.js";

/** @typedef {import("./track.js").Track} Track */
/** @typedef {{u: number, v: number}} FramePlace */

const FASTEST = 2;
const TALLEST = 62; // vh
/** How the circle of a flag is drawn, beside its colour. */
/** @type {Record<string, number[]>} */
const DASHES = { ok: [], collision: [], manual: [], occluded: [8, 4], predicted: [2, 4],
  lost: [2, 8] };
// The model's ball is drawn around the measured one.
const GHOST = 1.25;
const DARK = "#14161c";

export class Screen {
  constructor() {
    this.video = el("video", { class: "clip", muted: true, playsInline: true, preload: "auto",
      "aria-hidden": "true", tabindex: "-1" });
    this.canvas = el("canvas", { class: "clip-canvas", role: "img", "aria-label": t("clipLabel") });
    this.over = el("div", { class: "clip-over" });
    this.box = el("div", { class: "clip-box" }, this.video, this.canvas, this.over);
    this.clock = new ClipClock(this.video);
    /** @type {Track | null} */
    this.track = null;
    this.isMarked = true;
    this.hasGhost = true;
    this.frames = 1;
    this.size = { width: 1, height: 1 };
    /** What else is drawn, in the picture's pixels. */
    /** @type {((context: CanvasRenderingContext2D, scale: number) => void) | null} */
    this.sketch = null;
    /** Where balls and ghosts were last drawn, in pixels of the canvas, and of which frame. */
    this.drawn = { frame: -1, balls: /** @type {{x: number, y: number}[]} */ ([]),
      ghosts: /** @type {{x: number, y: number}[]} */ ([]) };
    this.transport = this.makeTransport();
    this.flags = el("p", { class: "flags" });
    this.failed = el("p", { class: "error", role: "alert", hidden: true }, t("cannotPlay"));
    this.root = el("div", { class: "stage" }, this.box, this.failed, this.transport, this.flags);
    this.release = fitCanvas(this.canvas, () => this.draw());
    this.clock.subscribe(() => this.move());
    this.video.addEventListener("loadeddata", () => this.draw());
    this.video.addEventListener("error", () => { this.failed.hidden = !this.video.currentSrc; });
    followKeys(this.root, { " ": { text: "keyPlay", act: () => this.clock.toggle() },
      ",": { text: "keyBack", act: () => this.stepBy(-1) }, ".": { text: "keyOn", act: () => this.stepBy(1) } });
  }

  makeTransport() {
    const step = (/** @type {string} */ name, /** @type {string} */ sign,
      /** @type {number} */ by) => el("button", { type: "button", class: "plain",
      "aria-label": t(name), on: { click: () => this.stepBy(by) } }, sign);
    const check = (/** @type {string} */ name, /** @type {"isMarked" | "hasGhost"} */ what) => {
      const { root, box } = tick(t(name), (on) => {
        this[what] = on;
        this.draw();
      });
      box.checked = true;
      return root;
    };
    this.button = el("button", { type: "button", class: "play",
      on: { click: () => this.clock.toggle() } }, t("play"));
    this.scrub = el("input", { type: "range", min: "0", max: "0", step: "1", value: "0",
      class: "scrub", "aria-label": t("frame"), on: { input: () => {
        this.clock.pause();
        this.clock.go(Number(this.scrub?.value));
      } } });
    this.timeText = el("output", { class: "time wide" });
    this.read = el("output", { class: "reading" });
    this.marks = el("span", { class: "row" }, check("overlay", "isMarked"),
      check("model", "hasGhost"));
    return el("div", { class: "transport" },
      el("div", { class: "row" }, this.button, step("frameBack", "◂", -1),
        step("frameOn", "▸", 1), this.scrub),
      el("div", { class: "row" }, this.timeText, this.read),
      el("div", { class: "row" }, ...speedMenu(FASTEST, (speed) => this.clock.hurry(speed)), this.marks));
  }

  /**
   * Show a clip.
   * @param {{url: string, width: number, height: number, times: ArrayLike<number>}} clip
   * @param {Track | null} track
   */
  show(clip, track) {
    this.track = track;
    this.size = { width: clip.width, height: clip.height };
    this.box.style.aspectRatio = `${clip.width} / ${clip.height}`;
    this.box.style.maxWidth = `calc(${TALLEST}vh * ${clip.width / clip.height})`;
    if (this.video.src !== clip.url) {
      this.clock.pause();
      this.clock.index = 0;
      this.failed.hidden = true;
      this.video.src = clip.url;
      this.drawn.frame = -1;
    }
    this.clock.load(track?.media ?? clip.times, track?.time ?? clip.times);
    this.frames = clip.times.length;
    if (this.scrub) this.scrub.max = String(this.clock.times.length - 1);
    if (this.marks) this.marks.hidden = !track;
    this.flags.replaceChildren(...(track?.counts() ?? []).map(({ flag, count }) =>
      el("span", { class: "flag", title: t(`flag_${flag}_hint`) },
        el("span", { class: `key flag-${flag}` }),
        t("flagCount", { flag: t(`flag_${flag}`), count }))));
    this.move();
  }

  /** Return the number in the file of the frame on show. */
  get frame() {
    return this.clock.index + (this.track?.firstFrame ?? 0);
  }

  /** @param {number} frame of the file */
  goTo(frame) {
    this.clock.pause();
    this.clock.go(frame - (this.track?.firstFrame ?? 0));
  }

  /** @param {number} by frames */
  stepBy(by) {
    this.clock.pause();
    this.clock.go((this.clock.wanted ?? this.clock.index) + by);
  }

  move() {
    this.draw();
    const { clock } = this;
    const label = clock.playing ? t("pause") : t("play");
    if (this.button && this.button.textContent !== label) this.button.textContent = label;
    if (!clock.isRead) return;
    if (this.scrub) this.scrub.value = String(clock.index);
    if (this.timeText) this.timeText.textContent = t("frameText", {
      frame: this.frame, last: this.frames - 1, time: clock.time.toFixed(3) });
    if (this.read) this.read.textContent = this.reading();
  }

  /** Return angles and flags of the frame in words. */
  reading() {
    const { track, clock } = this;
    if (!track?.hasAngles) return "";
    const sign = (/** @type {number} */ x) => x.toFixed(2).replace("-", "−");
    return Array.from({ length: track.count }, (_, b) => {
      const angle = track.values("angle", b)[clock.index];
      const sigma = track.values("angle_sigma", b)[clock.index];
      const flag = track.flag(clock.index, b);
      const value = Number.isFinite(angle)
        ? t("angleText", { angle: sign(angle / DEGREE), sigma: (sigma / DEGREE).toFixed(2) })
        : "–";
      const side = track.count > 1 ? `${t(SIDES[b])} ` : "";
      return `${side}${value}${flag === "ok" ? "" : `, ${t(`flag_${flag}`)}`}`;
    }).join(" · ");
  }

  /**
   * The position on the canvas of a place of the picture, in the canvas's own pixels.
   * @param {FramePlace} place in pixels, whole numbers in their middle
   */
  onCanvas({ u, v }) {
    const { canvas, size } = this;
    return { x: ((u + 0.5) * canvas.width) / size.width,
      y: ((v + 0.5) * canvas.height) / size.height };
  }

  draw() {
    const { canvas, video, track, clock } = this;
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, canvas.width, canvas.height);
    // The picture itself, so that it and what is drawn on it are always of one frame.
    if (video.readyState >= 2) context.drawImage(video, 0, 0, canvas.width, canvas.height);
    const scale = canvas.width / this.size.width;
    if (this.sketch) this.sketch(context, scale);
    this.drawn = { frame: clock.index, balls: [], ghosts: [] };
    if (!track) return;
    const { pivot, balls, ghosts } = track.places(clock.index);
    const radius = track.radius * scale;
    const ratio = window.devicePixelRatio || 1;
    const hinge = this.onCanvas(pivot);
    this.drawn.balls = balls.map((place) => this.onCanvas(place));
    this.drawn.ghosts = ghosts.map((place) => this.onCanvas(place));
    if (this.hasGhost) {
      for (const at of this.drawn.ghosts)
        this.ball(context, hinge, at, GHOST * radius, colour("model", canvas), [4 * ratio, 4 * ratio]);
    }
    if (!this.isMarked) return;
    this.drawn.balls.forEach((at, b) => {
      const flag = track.flag(clock.index, b);
      const paint = colour(`flag-${flag}`, canvas);
      this.ball(context, hinge, at, radius, paint, DASHES[flag].map((d) => d * ratio));
      drawBallCross(context, at, 3 * ratio, paint, ratio);
    });
    drawBallCross(context, hinge, 0.5 * radius + 3 * ratio, "#ffffff", ratio);
  }

  /**
   * Draw a rod and the edge of a ball, light over dark, to be seen on any ground.
   * @param {CanvasRenderingContext2D} context
   * @param {{x: number, y: number}} hinge
   * @param {{x: number, y: number}} at
   * @param {number} radius
   * @param {string} paint
   * @param {number[]} dash
   */
  ball(context, hinge, at, radius, paint, dash) {
    if (!Number.isFinite(at.x + at.y)) return;
    const ratio = window.devicePixelRatio || 1;
    const away = Math.hypot(at.x - hinge.x, at.y - hinge.y);
    const share = 1 - Math.min(radius / Math.max(away, 1e-9), 1);
    const path = new Path2D();
    if (Number.isFinite(away)) {
      path.moveTo(hinge.x, hinge.y);
      path.lineTo(hinge.x + share * (at.x - hinge.x), hinge.y + share * (at.y - hinge.y));
    }
    path.moveTo(at.x + radius, at.y);
    path.arc(at.x, at.y, radius, 0, 2 * Math.PI);
    outline(context, path, [DARK, 4 * ratio], [paint, 2 * ratio, dash]);
  }
}

/**
 * Draw a cross, light over dark, where there is one.
 * @param {CanvasRenderingContext2D} context
 * @param {{x: number, y: number}} at
 * @param {number} reach
 * @param {string} paint
 * @param {number} ratio
 */
function drawBallCross(context, { x, y }, reach, paint, ratio) {
  if (Number.isFinite(x + y)) outline(context, cross(x, y, reach), [DARK, 3.5 * ratio], [paint, 1.5 * ratio]);
}
