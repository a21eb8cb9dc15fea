/** Keys of a view, where no other element wants them. */

/**
 * Do what a key stands for while the focus is inside `root`; returns nothing.
 * @param {HTMLElement} root
 * @param {Record<string, () => void>} actions by the name of the key
 */
export function followKeys(root, actions) {
  root.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || wants(event)) return;
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
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
    case "A":
    case "SUMMARY":
      return event.key === " " || event.key === "Enter";
    default:
      return false;
  }
}
