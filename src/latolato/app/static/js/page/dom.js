/** Elements in one line. */

/**
 * Return an element with attributes and children; `on` holds listeners, `class` its classes.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, any>} [attributes]
 * @param {...(Node | string | null | undefined | false)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === "on") {
      for (const [event, listener] of Object.entries(value))
        element.addEventListener(event, /** @type {EventListener} */ (listener));
    } else if (name in element && name !== "list" && name !== "form" && typeof value !== "string") {
      /** @type {any} */ (element)[name] = value;
    } else element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children.filter((c) => c !== null && c !== undefined && c !== false)
    .map((c) => /** @type {Node | string} */ (c)));
  return element;
}

/**
 * Return a box to tick with its label.
 * @param {string} label
 * @param {(on: boolean) => void} change
 */
export function tick(label, change) {
  const box = el("input", { type: "checkbox", on: { change: () => change(box.checked) } });
  const text = el("span", {}, label);
  const root = el("label", { class: "check" }, box, text);
  return { root, box, text };
}

/** Colours that were read, by element and name. @type {WeakMap<Element, Map<string, string>>} */
let colours = new WeakMap();
// Listens before anything that draws; there is no theme where pages run without a window.
globalThis.addEventListener?.("themechange", () => { colours = new WeakMap(); });

/**
 * Return the value of a colour of the style sheet, as canvases need it: read once for each theme,
 * and empty for an element that is not in the page.
 * @param {string} name
 * @param {Element} [element]
 * @returns {string}
 */
export function colour(name, element = document.documentElement) {
  const own = colours.get(element) ?? new Map();
  colours.set(element, own);
  let value = own.get(name);
  if (!value) {
    value = getComputedStyle(element).getPropertyValue(`--${name}`).trim();
    own.set(name, value);
  }
  return value;
}

/**
 * Return colours of the style sheet by their names.
 * @param {string[]} names
 * @param {Element} element
 * @returns {Record<string, string>}
 */
export function coloursOf(names, element) {
  return Object.fromEntries(names.map((name) => [name, colour(name, element)]));
}

/** Return whether the user prefers reduced motion. */
export function isCalm() {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}

/**
 * Call a function before the page is printed; returns what ends that.
 * @param {() => void} act
 */
export function beforePrint(act) {
  window.addEventListener("beforeprint", act);
  return () => window.removeEventListener("beforeprint", act);
}

/** Return whether an element is in the page, visible and not disabled. */
export function isUsable(/** @type {Element} */ element) {
  return element.checkVisibility() && !element.matches(":disabled");
}

let count = 0;

/** Return an id that no other element has. */
export function freshId() {
  count += 1;
  return `id${count}`;
}

/**
 * Show a line of text for a while, and to screen readers.
 * @param {string} text
 */
export function notify(text) {
  const place = document.getElementById("status");
  if (!place) return;
  place.textContent = text;
  place.hidden = false;
  clearTimeout(timer);
  timer = setTimeout(() => { place.hidden = true; }, 4000);
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

/**
 * Call functions after a change of the theme, and of an element's size; returns what ends that.
 * @param {Element} element
 * @param {() => void} redraw
 * @param {() => void} resize
 */
export function onLook(element, redraw, resize) {
  const observer = new ResizeObserver(resize);
  observer.observe(element);
  window.addEventListener("themechange", redraw);
  return () => {
    observer.disconnect();
    window.removeEventListener("themechange", redraw);
  };
}

/**
 * Keep the size of a canvas in device pixels; `draw` is called after a change of size or theme.
 * Returns what ends that.
 * @param {HTMLCanvasElement} canvas
 * @param {() => void} draw
 */
export function fitCanvas(canvas, draw) {
  return onLook(canvas, draw, () => {
    const ratio = window.devicePixelRatio || 1;
    const box = canvas.getBoundingClientRect();
    const width = Math.max(1, Math.round(box.width * ratio));
    const height = Math.max(1, Math.round(box.height * ratio));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    draw();
  });
}

/**
 * Rebuild the children of an element if their content has changed; otherwise they keep the focus.
 * @param {HTMLElement} place
 * @param {any} content
 * @param {() => (Node | string)[]} make
 */
export function refresh(place, content, make) {
  const text = JSON.stringify(content);
  if (place.dataset.content === text) return;
  place.dataset.content = text;
  place.replaceChildren(...make());
}

/**
 * Return nothing; the browser stores a file under a name.
 * @param {Blob} file
 * @param {string} name
 */
export function saveFile(file, name) {
  const address = URL.createObjectURL(file);
  const link = el("a", { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
