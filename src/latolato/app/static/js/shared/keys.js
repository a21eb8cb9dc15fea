/** Keys of a view, where no other element wants them. */

/**
 * Do what a key stands for while the focus is inside of `root`; returns what ends that.
 * @param {HTMLElement | Document} root
 * @param {Record<string, () => void>} actions by the name of the key
 */
export function followKeys(root, actions) {
  const follow = (/** @type {Event} */ event) => {
    const pressed = /** @type {KeyboardEvent} */ (event);
    if (pressed.defaultPrevented || pressed.ctrlKey || pressed.metaKey || pressed.altKey) return;
    const action = actions[pressed.key];
    if (!action || wants(pressed)) return;
    pressed.preventDefault();
    action();
  };
  root.addEventListener("keydown", follow);
  return () => root.removeEventListener("keydown", follow);
}

/** Return whether the element that has the focus needs a key itself. */
function wants(/** @type {KeyboardEvent} */ event) {
  const target = /** @type {HTMLElement} */ (event.target);
  switch (target.tagName) {
    case "SELECT":
    case "TEXTAREA":
      return true;
    case "INPUT": {
      const { type } = /** @type {HTMLInputElement} */ (target);
      if (type === "range") return event.key.startsWith("Arrow");
      return type !== "checkbox" || event.key === " ";
    }
    case "BUTTON":
    case "SUMMARY":
      return event.key === " " || event.key === "Enter";
    case "A":
      return event.key === "Enter";
    default:
      return false;
  }
}
