/** Handles on a frame: pivot, balls and more, dragged or moved by arrow keys, under a loupe. */

import { el } from "../page/dom.js";
import { cross, outline } from "../player/canvas.js";
import { t } from "../strings.js";

/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {{u: number, v: number}} HandlePlace */

const LOUPE = 128; // CSS pixels
const ZOOM = 6;
const FAR = 10;
// What is drawn is light over dark, to be seen on any ground.
const [DARK, LIGHT] = ["#14161c", "#ffffff"];
/** @type {Record<string, [number, number]>} */
const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class Handles {
  /**
   * @param {Screen} screen
   * @param {(name: string) => void} changed called when something was moved by hand
   * @param {(name: string) => void} confirmed called when something was clicked on
   */
  constructor(screen, changed, confirmed) {
    this.screen = screen;
    this.changed = changed;
    this.confirmed = confirmed;
    /** @type {Record<string, HandlePlace>} */
    this.places = {};
    /** Radius of a ball by what was said, over the length. */
    this.ratio = 0;
    this.radius = 0;
    /** Half the side of a template as it was given, over the radius, or over the arm. */
    this.patch = /** @type {{half: number, round?: number, share?: number} | null} */ (null);
    this.loupe = el("canvas", { class: "loupe", hidden: true, "aria-hidden": "true" });
    this.loupe.width = this.loupe.height = LOUPE;
    /** @type {Record<string, HTMLButtonElement>} */
    this.buttons = {};
    screen.over.append(this.loupe);
    screen.sketch = (context, scale) => this.sketch(context, scale);
    this.isOn = false;
  }

  /**
   * Show handles at places [pixels], or none.
   * @param {Record<string, HandlePlace> | null} places "pivot", "ball_1" and so on
   */
  show(places) {
    const names = Object.keys(places ?? {});
    if (names.length > 0 && names.join() === Object.keys(this.buttons).join()) {
      // The same handles elsewhere: they keep the focus.
      this.places = { ...places };
      for (const name of names) this.put(name);
      this.screen.draw();
      return;
    }
    for (const button of Object.values(this.buttons)) button.remove();
    this.buttons = {};
    this.isOn = places !== null;
    this.loupe.hidden = true;
    this.places = places ? { ...places } : {};
    for (const name of Object.keys(this.places)) {
      const button = el("button", { type: "button", class: `handle ${name}`, on: {
        keydown: (/** @type {KeyboardEvent} */ e) => this.key(name, e),
        pointerdown: (/** @type {PointerEvent} */ e) => this.drag(name, e),
        click: () => this.confirmed(name),
        focus: () => this.look(name),
        blur: () => { this.loupe.hidden = true; },
      } });
      this.buttons[name] = button;
      this.screen.over.append(button);
      this.put(name);
    }
    this.screen.draw();
  }

  /** @param {string} name */
  put(name) {
    const { width, height } = this.screen.size;
    const { u, v } = this.places[name];
    const button = this.buttons[name];
    button.style.left = `${(100 * (u + 0.5)) / width}%`;
    button.style.top = `${(100 * (v + 0.5)) / height}%`;
    button.setAttribute("aria-label", t("handle", {
      name: t(name === "ball_1" && !this.places.ball_2 ? "ball" : name),
      column: Math.round(u), row: Math.round(v) }));
  }

  /**
   * @param {string} name
   * @param {number} u
   * @param {number} v
   */
  move(name, u, v) {
    const { width, height } = this.screen.size;
    const inside = (/** @type {number} */ x, /** @type {number} */ end) =>
      Math.round(10 * Math.min(Math.max(x, 0), end - 1)) / 10;
    this.places[name] = { u: inside(u, width), v: inside(v, height) };
    this.put(name);
    this.screen.draw();
    this.look(name);
    this.changed(name);
  }

  /**
   * @param {string} name
   * @param {KeyboardEvent} event
   */
  key(name, event) {
    const step = STEPS[event.key];
    if (!step) return;
    event.preventDefault();
    const size = event.shiftKey ? FAR : event.ctrlKey || event.altKey ? 0.1 : 1;
    const { u, v } = this.places[name];
    this.move(name, u + size * step[0], v + size * step[1]);
  }

  /**
   * @param {string} name
   * @param {PointerEvent} event
   */
  drag(name, event) {
    const button = this.buttons[name];
    button.focus();
    event.preventDefault();
    button.setPointerCapture(event.pointerId);
    const box = this.screen.over.getBoundingClientRect();
    const { width, height } = this.screen.size;
    const from = { ...this.places[name], x: event.clientX, y: event.clientY };
    const onMove = (/** @type {PointerEvent} */ e) => this.move(name,
      from.u + ((e.clientX - from.x) * width) / box.width,
      from.v + ((e.clientY - from.y) * height) / box.height);
    const onEnd = () => {
      button.removeEventListener("pointermove", onMove);
      button.removeEventListener("pointerup", onEnd);
      button.removeEventListener("pointercancel", onEnd);
    };
    button.addEventListener("pointermove", onMove);
    button.addEventListener("pointerup", onEnd);
    button.addEventListener("pointercancel", onEnd);
  }

  /**
   * Show what is under a handle, enlarged, away from it.
   * @param {string} name
   */
  look(name) {
    const { video, size } = this.screen;
    const context = this.loupe.getContext("2d");
    if (!context || video.readyState < 2) return;
    const { u, v } = this.places[name];
    this.loupe.hidden = false;
    this.loupe.dataset.corner = this.freeCorner();
    const scale = video.videoWidth / size.width;
    const span = (LOUPE / ZOOM) * scale;
    context.imageSmoothingEnabled = false;
    context.fillStyle = DARK;
    context.fillRect(0, 0, LOUPE, LOUPE);
    context.drawImage(video, (u + 0.5) * scale - span / 2, (v + 0.5) * scale - span / 2, span, span,
      0, 0, LOUPE, LOUPE);
    outline(context, cross(LOUPE / 2, LOUPE / 2, 14), [DARK, 3.5], [LIGHT, 1.5]);
  }

  /** Return the corner of the picture that is farthest from all handles. */
  freeCorner() {
    const { width, height } = this.screen.size;
    const distance = (/** @type {string} */ name) => Math.min(...Object.values(this.places)
      .map(({ u, v }) => Math.hypot(u - (name.includes("right") ? width : 0),
        v - (name.includes("bottom") ? height : 0))));
    return ["top left", "top right", "bottom left", "bottom right"]
      .reduce((best, name) => (distance(name) > distance(best) ? name : best));
  }

  /**
   * Draw rods and the balls' edges between the handles, as long as nothing is tracked.
   * @param {CanvasRenderingContext2D} context
   * @param {number} scale
   */
  sketch(context, scale) {
    if (!this.isOn) return;
    const { pivot, region_1: corner, region_2: other, stick_1: end, stick_2: tip } = this.places;
    const at = (/** @type {HandlePlace} */ place) => this.screen.onCanvas(place);
    const ratio = window.devicePixelRatio || 1;
    const path = new Path2D();
    for (const name of ["ball_1", "ball_2"]) {
      const ball = this.places[name];
      if (!ball) continue;
      const radius = this.radiusOf(ball) * scale;
      const { x, y } = at(ball);
      if (pivot) {
        path.moveTo(at(pivot).x, at(pivot).y);
        path.lineTo(x, y);
      }
      path.moveTo(x + radius, y);
      path.arc(x, y, radius, 0, 2 * Math.PI);
    }
    if (corner) {
      const [one, two] = [at(corner), at(other)];
      path.rect(one.x, one.y, two.x - one.x, two.y - one.y);
    }
    if (end) {
      path.moveTo(at(end).x, at(end).y);
      path.lineTo(at(tip).x, at(tip).y);
    }
    outline(context, path, [DARK, 3.5 * ratio], [LIGHT, 1.5 * ratio]);
  }

  /**
   * Return the radius of the circle that is drawn about a ball [pixels]: its edge, or its patch.
   * @param {HandlePlace} ball
   */
  radiusOf(ball) {
    const { pivot } = this.places;
    const arm = pivot ? Math.hypot(ball.u - pivot.u, ball.v - pivot.v) : 0;
    const radius = this.ratio && arm ? this.ratio * arm : 0;
    if (!this.patch) return radius || this.radius;
    const { half, round = 0, share = 0 } = this.patch;
    return half || round * radius || share * arm || this.radius;
  }
}
