/** Numbers and units as people write them. */

import { asRead, superscript } from "../model/rules.js";
import { local } from "../strings.js";

/** @typedef {{name: string, size: number}} Unit */

/** One degree [rad]. */
export const DEGREE = Math.PI / 180;

const SHOWN = { us: "µs", deg: "°", "1": "", "deg/s": "°/s", "m/s^2": "m/s²", "kg*m/s": "kg·m/s",
  "kg*m": "kg·m", "rad/s^(3/2)": "rad/s³ᐟ²", "rad^2*s": "rad²s", "rad^2/s": "rad²/s" };

/**
 * Return a unit as it is shown.
 * @param {string} unit
 * @returns {string}
 */
export function shownUnit(unit) {
  return /** @type {Record<string, string>} */ (SHOWN)[unit] ?? unit.replace("^2", "²");
}

/**
 * Return a number with its unit: degrees stand at the number, other units apart from it.
 * @param {string} number
 * @param {string} unit as it is shown
 * @param {string} [gap]
 */
export function besideUnit(number, unit, gap = " ") {
  return `${number}${unit && !unit.startsWith("°") ? gap : ""}${unit}`;
}

// Below this numbers are written as powers of ten.
const SMALL = 1e-4;

/**
 * Return a number with so many digits, without trailing zeros.
 * @param {number} value
 * @param {number} [digits]
 * @returns {string}
 */
export function short(value, digits = 6) {
  if (!Number.isFinite(value)) return "";
  if (value !== 0 && Math.abs(value) < SMALL)
    return value.toExponential(digits - 1).replace(/\.?0*e/, "e");
  const text = value.toPrecision(digits);
  if (text.includes("e")) return String(Number(text));
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

/**
 * Return a number as a sentence has it: a whole one as it is, very large and very small ones as powers of ten or two.
 * @param {number} value
 * @returns {string}
 */
export function inProse(value) {
  const size = Math.abs(value);
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (Number.isSafeInteger(value)) return String(value);
  if (size >= SMALL && size < Number.MAX_SAFE_INTEGER) return short(value);
  if (value > 1 && Number.isInteger(Math.log2(value))) return `2${superscript(Math.log2(value))}`;
  return asRead(Number(value.toPrecision(4)).toExponential());
}

// How many digits the ends of intervals are shown with.
const END_DIGITS = 4;
// Two numbers are the same up to so much of them, as after a conversion of units.
const SAME = 1e-12;

/**
 * Return the end of an interval as it is shown: a whole number as it is, others rounded to a number that the
 * interval holds.
 * @param {number} end
 * @param {boolean} isLower
 * @returns {number}
 */
export function shownEnd(end, isLower) {
  if (Number.isInteger(end)) return end;
  const nearest = Number(end.toPrecision(END_DIGITS));
  const excess = isLower ? end - nearest : nearest - end;
  if (!(excess > SAME * Math.abs(end))) return nearest;
  const place = 10 ** (Math.floor(Math.log10(Math.abs(end))) + 1 - END_DIGITS);
  return Number((nearest + (isLower ? place : -place)).toPrecision(END_DIGITS));
}

/**
 * Return a number with so many digits, as the language of the page writes it.
 * @param {number} value
 * @param {number} [digits]
 */
export function localShort(value, digits) {
  return local(short(value, digits));
}

/** @param {string} text */
const localRead = (text) => local(asRead(text));

/**
 * Return a number to the place of the second digit of its standard deviation, with that.
 * @param {number} value
 * @param {number} sigma
 * @returns {string}
 */
export function withSigma(value, sigma) {
  if (!Number.isFinite(value)) return "–";
  if (!(sigma > 0) || !Number.isFinite(sigma)) return localRead(short(value));
  const largest = Math.floor(Math.log10(Math.max(Math.abs(value), sigma)));
  // Small and large numbers as powers of ten, to be read at a glance.
  const power = largest < -3 || largest > 5 ? largest : 0;
  const [a, b] = [value / 10 ** power, sigma / 10 ** power];
  const digits = Math.min(Math.max(1 - Math.floor(Math.log10(b)), 0), 12);
  const both = `${localRead(a.toFixed(digits))} ± ${local(b.toFixed(digits))}`;
  return power ? `(${both}) × 10${superscript(power)}` : both;
}

/**
 * Return a number to the place of the second digit of a standard deviation.
 * @param {number} value
 * @param {number} sigma
 * @returns {string}
 */
export function toPlace(value, sigma) {
  const digits = 1 - Math.floor(Math.log10(sigma));
  if (digits >= 0 && digits <= 12 && Math.max(Math.abs(value), sigma) >= SMALL)
    return localRead(value.toFixed(digits));
  // Small and large numbers as powers of ten, with the figures down to that place.
  const steps = Math.round(value * 10 ** digits);
  if (steps === 0) return "0";
  if (!Number.isFinite(steps)) return localRead(short(value, 5));
  const figures = Math.floor(Math.log10(Math.abs(steps))) + 1;
  return localRead(short(steps / 10 ** digits, Math.min(figures, 12)));
}

const LETTERS = { theta: "θ", omega: "ω", varphi: "φ", gamma: "γ", delta: "δ", tau: "τ",
  Theta: "Θ", pi: "π", sigma: "σ", Delta: "Δ", alpha: "α", lambda: "λ", mu: "μ", zeta: "ζ",
  varepsilon: "ε", epsilon: "ε", langle: "⟨", rangle: "⟩" };

/**
 * Return the parts of a symbol written in TeX as text, each on the line, below or above it.
 * @param {string} tex such as "\\dot\\theta_0"
 * @returns {{text: string, place: "line" | "sub" | "sup"}[]}
 */
export function symbolParts(tex) {
  const plain = tex
    .replace(/\\(d?dot)\s*\{?(\\?\w+?)\}?(?=_|\^|\s|$|[^\w])/g, (_, dot, name) =>
      `${name}${dot === "ddot" ? "\u0308" : "\u0307"}`)
    .replace(/\\mathrm\{(\w+)\}/g, "$1")
    .replace(/\\([A-Za-z]+) ?/g, (_, name) => /** @type {Record<string, string>} */ (LETTERS)[name] ?? name)
    .replace(/\\,/g, " ");
  /** @type {{text: string, place: "line" | "sub" | "sup"}[]} */
  const parts = [];
  for (const match of plain.matchAll(/([_^])(?:\{([^}]*)\}|(.))|([^_^]+)/g)) {
    const [, mark, group, letter, rest] = match;
    const text = (group ?? letter ?? rest).replace(/[{}$]/g, "");
    if (text) parts.push({ text, place: mark === "_" ? "sub" : mark === "^" ? "sup" : "line" });
  }
  return parts;
}

/**
 * Return a symbol written in TeX as one line of text, for canvases and lists.
 * @param {string} tex
 * @returns {string}
 */
export function plainSymbol(tex) {
  return symbolParts(tex).map(({ text, place }) => {
    if (place === "sub") return /^\d+$/.test(text) ? below(text) : `_${text}`;
    if (place === "sup") return text === "2" ? "²" : `^${text}`;
    return text;
  }).join("");
}

/** @param {string} digits */
function below(digits) {
  return [...digits].map((digit) => "₀₁₂₃₄₅₆₇₈₉"[Number(digit)]).join("");
}
