/** Dragging a ball or the hand with a mouse, a pen or a finger. */

/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./motion.js").MotionBall} MotionBall */

// A ball is caught this far from its edge: fingers are broad.
const REACH = 28; // pixels of the page
// A press that moves less leads nowhere.
const STILL = 3; // pixels of the page
// Stands for the hand among the balls on show.
const HAND = -1;

/**
 * Let a pointer lead the balls of a scene, and the hand if it can be lifted.
 * @param {Scene} scene
 * @param {{isOn?: () => boolean, grab: (ball: MotionBall) => void, lead: (ball: MotionBall, angle: number) => void,
 *   drop: () => void, lift?: (height: number | null) => void}} hand whether balls can be caught; then
 *   what to do when one is, when it is led to an angle [rad], and when it is let go; and when the hand
 *   is dragged to a height [m], null when that is let go
 */
export function followDrag(scene, { isOn = () => true, grab, lead, drop, lift }) {
  const { canvas } = scene;
  /** @type {{index: number, from: [number, number], moved: boolean} | null} */
  let held = null;
  // Where the pointer was, in pixels of the canvas, and the height to which it has dragged the hand.
  let before = 0;
  let height = 0;
  const point = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    return [((event.clientX - box.left) * canvas.width) / box.width,
      ((event.clientY - box.top) * canvas.height) / box.height];
  };
  const nearest = (/** @type {PointerEvent} */ event) => {
    const { motion } = scene;
    if (!motion || !isOn()) return null;
    const [x, y] = point(event);
    const { size, ratio } = scene.scale();
    let nearest = null;
    let least = REACH * ratio;
    const pose = scene.pose();
    if (lift && pose) {
      const [px, py] = scene.place(pose.across, pose.height);
      const far = Math.hypot(px - x, py - y);
      if (far < least) [nearest, least] = [HAND, far];
    }
    scene.drawn.forEach((ball, k) => {
      const far = Math.hypot(ball.x - x, ball.y - y) - motion.radius(motion.balls[k]) * size;
      if (far < least) [nearest, least] = [k, far];
    });
    return nearest;
  };
  canvas.addEventListener("pointerdown", (event) => {
    const index = nearest(event);
    if (index === null || !scene.motion) return;
    held = { index, from: [event.clientX, event.clientY], moved: false };
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("held");
    [, before] = point(event);
    height = scene.pose()?.height ?? 0;
    if (index !== HAND) grab(scene.motion.balls[index]);
  });
  // A finger on a ball does not scroll the page.
  canvas.addEventListener("touchstart", (event) => {
    if (held) event.preventDefault();
  }, { passive: false });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) {
      canvas.classList.toggle("near", nearest(event) !== null);
      return;
    }
    const [fromX, fromY] = held.from;
    held.moved ||= Math.hypot(event.clientX - fromX, event.clientY - fromY) > STILL;
    if (held.index === HAND) {
      const [, y] = point(event);
      // The picture may change its scale under the pointer.
      height += (before - y) / scene.scale().size;
      before = y;
      lift?.(height);
      return;
    }
    const pose = scene.pose();
    const led = pose?.balls[held.index];
    if (!held.moved || !pose || !led) return;
    const { ball, angle } = led;
    const [x, y] = point(event);
    const [px, py] = scene.place(pose.across, pose.height);
    const pointer = Math.atan2(x - px, y - py);
    // Of all turns the one that is next to where the ball is.
    const turn = 2 * Math.PI * Math.round((angle - pointer) / (2 * Math.PI));
    lead(ball, ball.sign * (pointer + turn));
  });
  const free = () => {
    if (!held) return;
    if (held.index === HAND) lift?.(null);
    else drop();
    held = null;
    canvas.classList.remove("held");
  };
  canvas.addEventListener("pointerup", free);
  canvas.addEventListener("pointercancel", free);
}
