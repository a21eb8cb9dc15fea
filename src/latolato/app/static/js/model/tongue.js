/**
 * The edges of the primary Mathieu tongue (paper eq14), as `mathieu_tongue_edges` of
 * `latolato.analysis.mathieu`, by another formula.
 *
 * With `s = 2 w0/w`, `q = 2 A0/l` and the damping ratio `zeta` an edge is where the linear equation
 * has a solution of twice the drive's period: its odd harmonics obey `D_k c_k = q (c_(k-2) + c_(k+2))`
 * with `D_k = s^2 - k^2 + 2 i zeta s k`. What lies above the first harmonic gives the continued
 * fraction `R = D_1 - q^2/(D_3 - q^2/(D_5 - ...))`, what lies below its conjugate, so that edges are
 * where `|R| = q`; between them `|R| < q`.
 */

// With twenty harmonics the fraction is exact to rounding up to q = 8, where the tongue has ended.
const LAST = 39;
// The hump between the edges of a damped tongue is searched in so many steps of golden section.
const SEARCH = 80;
const GOLDEN = (Math.sqrt(5) - 1) / 2;

/**
 * Return the lower and the upper edge [w/w0]: NaN where the tongue is closed or holds no hanging
 * pendulum any more, an upper edge of infinity where no fast drive is stable.
 * @param {number} q twice the drive's amplitude in lengths, at most 8
 * @param {number} zeta damping ratio C/(2 m l w0), below 1
 * @returns {[number, number]}
 */
export function tongueEdges(q, zeta) {
  const swing = Math.sqrt(1 - zeta * zeta);
  // Damping narrows the tongue, so its edges are searched between those without.
  const [least, most] = [lowestRoot(q, -q), lowestRoot(q, q)];
  if (most <= 0) return [NaN, NaN];
  const [start, end] = [Math.sqrt(Math.max(least, 0)) / swing, Math.sqrt(most) / swing];
  const ratio = (/** @type {number} */ s) => (s > 0 ? 2 / s : Infinity);
  if (zeta === 0) return [ratio(end), ratio(start)];
  const excess = (/** @type {number} */ s) => q * q - squaredFraction(s, q, zeta);
  const inside = positiveBetween(excess, start, end);
  if (Number.isNaN(inside)) return [NaN, NaN];
  return [ratio(changeBetween((s) => excess(s) > 0, inside, end)),
    least > 0 ? ratio(changeBetween((s) => excess(s) <= 0, start, inside)) : Infinity];
}

/**
 * Return |R|^2.
 * @param {number} s
 * @param {number} q
 * @param {number} zeta
 */
function squaredFraction(s, q, zeta) {
  let [re, im] = [Infinity, 0];
  for (let k = LAST; k > 0; k -= 2) {
    const share = q * q / (re * re + im * im);
    re = s * s - k * k - share * re || 0;
    im = 2 * zeta * s * k + share * im || 0;
  }
  return re * re + im * im;
}

/**
 * Return the least s^2 for which R without damping is -`q` (a_1 of Mathieu) or `q` (b_1): the matrix
 * of the equation, which has `side` in its first place, is definite below it.
 * @param {number} q
 * @param {number} side
 */
function lowestRoot(q, side) {
  const isBelow = (/** @type {number} */ a) => {
    let pivot = Infinity;
    for (let k = LAST; k > 0; k -= 2) {
      pivot = k * k - a + (k === 1 ? side : 0) - q * q / pivot;
      if (!(pivot > 0)) return false;
    }
    return true;
  };
  return changeBetween(isBelow, -2 * q - 1, q + 2);
}

/**
 * The point from which a condition that holds on the left of an interval fails.
 * @param {(x: number) => boolean} holds
 * @param {number} left
 * @param {number} right
 */
export function changeBetween(holds, left, right) {
  let [low, high] = [left, right];
  for (;;) {
    const middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) return high;
    if (holds(middle)) low = middle;
    else high = middle;
  }
}

/**
 * A point at which a function with one hump is positive, NaN if there is none.
 * @param {(x: number) => number} hump
 * @param {number} left
 * @param {number} right
 */
function positiveBetween(hump, left, right) {
  let [low, high] = [left, right];
  for (let step = 0; step < SEARCH; step += 1) {
    const [a, b] = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    const [atA, atB] = [hump(a), hump(b)];
    if (atA > 0) return a;
    if (atB > 0) return b;
    if (atA > atB) high = b;
    else low = a;
  }
  return NaN;
}
