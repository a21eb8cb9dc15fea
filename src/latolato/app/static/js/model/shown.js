/** Numbers in the units in which people read them, as texts that Python reads without a loss. */

// 180/pi times 10^40.
const DEGREES = 572957795130823208767981548141051703324054n;
const PLACES = 40;
// A number in degrees needs more digits than one in radians to be the same number.
const DIGITS = 20;
/** @type {Record<string, number>} */
const POWERS = { mm: 3, cm: 2, g: 3 };

/**
 * Return whether numbers in SI units are written in this unit; others are written as they are.
 * @param {string} unit
 */
export function isShown(unit) {
  return unit === "deg" || Object.hasOwn(POWERS, unit);
}

/**
 * Return a number in SI units as a text in another unit.
 * @param {number} value
 * @param {string} unit
 * @returns {string}
 */
export function shownText(value, unit) {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  if (unit === "deg") return degreesText(value);
  const power = POWERS[unit];
  const [digits, exponent = "0"] = String(value).split("e");
  const short = String(Number(`${digits}e${Number(exponent) + power}`));
  const [most, last = "0"] = short.split("e");
  return Number(`${most}e${Number(last) - power}`) === value ? short : `${digits}e${Number(exponent) + power}`;
}

/** @param {number} radians */
function degreesText(radians) {
  // The number is a whole one times a power of two.
  let [whole, power] = [Math.abs(radians), 0];
  while (!Number.isInteger(whole)) [whole, power] = [whole * 2, power + 1];
  const product = BigInt(whole) * DEGREES;
  const digits = DIGITS - 1 - Math.floor(Math.log10(Math.abs(radians) * 180 / Math.PI));
  const shift = digits - PLACES;
  const [above, below] = shift < 0 ? [product, (1n << BigInt(power)) * 10n ** BigInt(-shift)]
    : [product * 10n ** BigInt(shift), 1n << BigInt(power)];
  const text = String((above + below / 2n) / below);
  const sign = radians < 0 ? "-" : "";
  if (digits <= 0 || digits > DIGITS + 6) return `${sign}${text}e${-digits}`;
  const long = text.padStart(digits + 1, "0");
  return `${sign}${long.slice(0, -digits)}.${long.slice(-digits)}`.replace(/\.?0+$/, "");
}
