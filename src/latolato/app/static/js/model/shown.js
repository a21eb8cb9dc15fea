/** Numbers in the units in which people read them, as texts that Python reads without a loss. */

// 180/pi times 10^40.
const DEGREES = 572957795130823208767981548141051703324054n;
const PLACES = 40;
// So many digits tell all numbers from each other.
const DIGITS = 17;
// Longer texts are written with a power of ten.
const LONGEST = 26;
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
 * Return a number in SI units as a text in another unit, from which Python makes the same number: the
 * shortest one of 15 to 17 digits, as `latolato.io.shown_units` does.
 * @param {number} value
 * @param {string} unit
 * @returns {string}
 */
export function shownText(value, unit) {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const sign = value < 0 ? "-" : "";
  if (unit === "deg") return sign + decimal(...degreesOf(Math.abs(value)));
  const [digits, exponent] = Math.abs(value).toExponential().split("e");
  const [above, below = ""] = digits.split(".");
  return sign + decimal(BigInt(above + below), below.length - Number(exponent) - POWERS[unit]);
}

/**
 * Return a number in degrees as a whole number and how many places its point is moved.
 * @param {number} radians above zero
 * @returns {[bigint, number]}
 */
function degreesOf(radians) {
  // The number is a whole one times a power of two; numbers beside it are one off, below a power half.
  let [whole, power] = [radians, 0];
  while (whole < 2 ** 52) [whole, power] = [whole * 2, power + 1];
  const product = BigInt(whole) * DEGREES;
  const above = DEGREES / 2n;
  const below = whole === 2 ** 52 ? above / 2n : above;
  const places = DIGITS - 1 - Math.floor(Math.log10((radians * 180) / Math.PI));
  const shift = places - PLACES;
  const [up, down] = shift < 0 ? [1n, 10n ** BigInt(-shift)] : [10n ** BigInt(shift), 1n];
  const unit = down << BigInt(power);
  const rounded = (/** @type {bigint} */ to) => ((product * up + (unit * to) / 2n) / (unit * to)) * to;
  for (const to of [100n, 10n]) {
    const error = rounded(to) * unit - product * up;
    if (error < above * up && -error < below * up) return [rounded(to), places];
  }
  return [rounded(1n), places];
}

/**
 * Return a whole number whose point is moved by some places as a text, without trailing zeros; a long
 * one with a power of ten.
 * @param {bigint} whole
 * @param {number} places
 */
function decimal(whole, places) {
  const digits = String(whole).replace(/0+$/, "");
  const left = places - (String(whole).length - digits.length);
  const long = left <= 0 ? digits + "0".repeat(-left)
    : digits.padStart(left + 1, "0").replace(new RegExp(`(.{${left}})$`), ".$1");
  if (long.length <= LONGEST) return long;
  const exponent = digits.length - 1 - left;
  return `${digits[0]}${digits.length > 1 ? `.${digits.slice(1)}` : ""}e${exponent}`;
}
