/** Dragging a ball or the pivot with a mouse, a pen or a finger. */

/** @typedef {import("../shared/scene.js").Scene} Scene */
/** @typedef {import("./motion.js").LiveMotion} LiveMotion */

// A ball is caught this far from its edge [CSS pixels]: fingers are broad.
const REACH = 28;

// Stands for the pivot among the balls on show.
const PIVOT = -1;

/**
 * Call `drag` with the row and the angle [rad] of the ball that a pointer leads, and `lift` with the
 * height [m] to which it drags the pivot, null when it lets go; returns nothing.
 * @param {HTMLCanvasElement} canvas
 * @param {Scene} scene
 * @param {() => LiveMotion | null} motion
 * @param {(held: {ball: number, angle: number} | null) => void} drag
 * @param {(height: number | null) => void} lift
 */
export function followHand(canvas, scene, motion, drag, lift) {
  /** @type {number | null} index of the ball on show, or the pivot */
  let held = null;
  // Where the pointer was, in pixels, and the height to which it has dragged the pivot.
  let before = 0;
  let height = 0;
  const point = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    return [((event.clientX - box.left) * canvas.width) / box.width,
      ((event.clientY - box.top) * canvas.height) / box.height];
  };
  const nearest = (/** @type {PointerEvent} */ event) => {
    const now = motion();
    if (!now) return null;
    const [x, y] = point(event);
    const ratio = window.devicePixelRatio || 1;
    const { size } = scene.scale();
    const [px, py] = scene.place(0, now.toy.pivot.height);
    let least = Math.hypot(px - x, py - y);
    let nearest = least < REACH * ratio ? PIVOT : null;
    scene.drawn.forEach((ball, k) => {
      const far = Math.hypot(ball.x - x, ball.y - y) - now.radius(now.balls[k]) * size;
      if (far < REACH * ratio && far < least) [nearest, least] = [k, far];
    });
    return nearest;
  };
  const lead = (/** @type {PointerEvent} */ event) => {
    const now = motion();
    if (held === null || !now) return;
    const [x, y] = point(event);
    if (held === PIVOT) {
      // The picture may change its scale under the pointer.
      height += (before - y) / scene.scale().size;
      before = y;
      lift(height);
      return;
    }
    const ball = now.balls[held];
    const [px, py] = scene.place(0, now.toy.pivot.height);
    const pointer = Math.atan2(x - px, y - py);
    // Of all turns the one that is next to where the ball is.
    const turn = 2 * Math.PI * Math.round((now.angle(ball) - pointer) / (2 * Math.PI));
    drag({ ball: ball.row, angle: ball.sign * (pointer + turn) });
  };
  canvas.addEventListener("pointerdown", (event) => {
    held = nearest(event);
    if (held === null) return;
    event.preventDefault();
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("held");
    [, before] = point(event);
    height = motion()?.toy.pivot.height ?? 0;
    lead(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (held !== null) lead(event);
    else canvas.classList.toggle("near", nearest(event) !== null);
  });
  const free = () => {
    if (held === null) return;
    if (held === PIVOT) lift(null);
    else drag(null);
    held = null;
    canvas.classList.remove("held");
  };
  canvas.addEventListener("pointerup", free);
  canvas.addEventListener("pointercancel", free);
}
