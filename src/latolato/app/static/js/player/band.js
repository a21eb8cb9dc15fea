/** Dense curves: what a pen of one pixel would leave, without false beats. */

// A swing narrower than this is no longer drawn as a line [pixels].
const NARROW = 3;

/**
 * Return the least and the largest value around every pixel column: of the samples within half a
 * `period` to both sides, so that a column never shows a part of a swing only.
 * @param {ArrayLike<number>} xs increasing
 * @param {ArrayLike<number>} ys
 * @param {number} from first sample
 * @param {number} to last sample
 * @param {(x: number) => number} position pixel of a value of x
 * @param {number} period in units of x
 */
export function envelope(xs, ys, from, to, position, period) {
  const first = Math.floor(position(xs[from]));
  const count = Math.max(1, Math.floor(position(xs[to])) - first + 1);
  const low = new Float64Array(count).fill(Infinity);
  const high = new Float64Array(count).fill(-Infinity);
  const offset = position(0);
  const slope = position(1) - offset;
  for (let i = from; i <= to; i += 1) {
    const y = ys[i];
    if (y !== y || y === null) continue;
    let k = Math.floor(offset + slope * xs[i]) - first;
    if (k < 0) k = 0;
    else if (k >= count) k = count - 1;
    if (y < low[k]) low[k] = y;
    if (y > high[k]) high[k] = y;
  }
  const reach = Math.ceil(0.5 * period * slope);
  return { first, low: slide(low, reach, Math.min), high: slide(high, reach, Math.max) };
}

/**
 * Return the extreme of each value and its neighbours up to `reach` away.
 * @param {Float64Array} values
 * @param {number} reach
 * @param {(a: number, b: number) => number} extreme
 */
function slide(values, reach, extreme) {
  if (reach < 1) return values;
  const result = new Float64Array(values.length);
  for (let i = 0; i < values.length; i += 1) {
    let best = values[i];
    for (let k = Math.max(0, i - reach); k <= Math.min(values.length - 1, i + reach); k += 1)
      best = extreme(best, values[k]);
    result[i] = best;
  }
  return result;
}

/**
 * Return whether swings of this period are too narrow to be drawn as a line.
 * @param {number} period in units of x
 * @param {number} pixels pixels of a unit of x
 */
export function isDense(period, pixels) {
  return period * pixels < NARROW;
}
