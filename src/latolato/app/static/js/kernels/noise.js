/**
 * Velocity kicks with the random numbers of `latolato.physics.noise`: NumPy's `Philox` and
 * `standard_normal`.
 *
 * Philox 4x64-10: J. K. Salmon et al., *Parallel random numbers: as easy as 1, 2, 3* (2011). The
 * normal distribution is drawn by a ziggurat of 256 layers: G. Marsaglia and W. W. Tsang, *The
 * ziggurat method for generating random variables* (2000).
 */

const WORD = 64n;
const MASK = (1n << WORD) - 1n;
const MULTIPLIERS = [0xD2E7470EE14C6C93n, 0xCA5A826395121157n];
const KEY_STEPS = [0x9E3779B97F4A7C15n, 0xBB67AE8584CAA73Bn];
const ROUNDS = 10;

const LAYERS = 256;
// Where the tail of the ziggurat begins, and the area of each of its layers.
const TAIL = 3.6541528853610087963519472518;
const AREA = 0.0049286732339746519;
const MANTISSA = 2 ** 52;
// Kicks in a natural period if no interval is given.
const PER_PERIOD = 50;
const MOST_KICKS = 20_000_000;

/** Return the next 64 random bits at each call. @param {bigint[]} key two numbers of 64 bits */
function philox(key) {
  let counter = 0n;
  /** @type {bigint[]} */
  let words = [];
  return () => {
    if (!words.length) {
      counter += 1n;
      let state = [counter, 0n, 0n, 0n];
      let [one, other] = key;
      for (let round = 0; round < ROUNDS; round += 1) {
        const [first, second] = [MULTIPLIERS[0] * state[0], MULTIPLIERS[1] * state[2]];
        state = [(second >> WORD) ^ state[1] ^ one, second & MASK,
          (first >> WORD) ^ state[3] ^ other, first & MASK];
        one = (one + KEY_STEPS[0]) & MASK;
        other = (other + KEY_STEPS[1]) & MASK;
      }
      words = state.reverse();
    }
    return /** @type {bigint} */ (words.pop());
  };
}

/** @type {{widths: number[], heights: number[], inner: number[]} | null} */
let ziggurat = null;

/** Return of each layer its width, the density at that, and the share below which all points lie. */
function layers() {
  if (ziggurat) return ziggurat;
  const density = (/** @type {number} */ x) => Math.exp(-0.5 * x * x);
  const widths = new Array(LAYERS).fill(0);
  widths[0] = AREA / density(TAIL);
  widths[LAYERS - 1] = TAIL;
  for (let i = LAYERS - 2; i > 0; i -= 1) {
    widths[i] = Math.sqrt(-2 * Math.log(AREA / widths[i + 1] + density(widths[i + 1])));
  }
  const heights = widths.map((width, i) => (i === 0 ? 1 : density(width)));
  const inner = widths.map((width, i) =>
    (i === 0 ? TAIL / width : i === 1 ? 0 : widths[i - 1] / width));
  ziggurat = { widths, heights, inner };
  return ziggurat;
}

/** Return the next normal number at each call. @param {bigint[]} key two numbers of 64 bits */
export function normals(key) {
  const next = philox(key);
  const uniform = () => Number(next() >> 11n) / 2 ** 53;
  const { widths, heights, inner } = layers();
  return () => {
    for (;;) {
      const bits = next();
      const layer = Number(bits & 0xFFn);
      const share = Number((bits >> 9n) & 0xFFFFFFFFFFFFFn) / MANTISSA;
      const sign = (bits >> 8n) & 1n ? -1 : 1;
      const x = sign * share * widths[layer];
      if (share < inner[layer]) return x;
      if (layer === 0) {
        for (;;) {
          const beyond = -Math.log1p(-uniform()) / TAIL;
          if (-2 * Math.log1p(-uniform()) > beyond * beyond) {
            return (bits >> 17n) & 1n ? -(TAIL + beyond) : TAIL + beyond;
          }
        }
      }
      const height = heights[layer] + (heights[layer - 1] - heights[layer]) * uniform();
      if (height < Math.exp(-0.5 * x * x)) return x;
    }
  };
}

/**
 * Return the instants [s] and sizes [rad/s] of velocity kicks; sizes of the second angle lie behind
 * those of the first.
 * @param {{noise_strength: number, noise_seed?: number | bigint, noise_stream?: number | bigint,
 *   noise_interval?: number | null}} noise
 * @param {{duration: number, natural_frequency: number, angles: number}} run the frequency is the
 *   right ball's
 * @returns {{times: Float64Array, sizes: Float64Array}}
 */
export function drawKicks(noise, { duration, natural_frequency, angles }) {
  const { noise_strength, noise_seed = 0, noise_stream = 0, noise_interval } = noise;
  const interval = noise_interval || (2 * Math.PI) / natural_frequency / PER_PERIOD;
  if (duration / interval > MOST_KICKS) {
    throw new Error(`${(duration / interval).toPrecision(3)} velocity kicks exceed the limit of ${
      MOST_KICKS}; make noise_interval longer`);
  }
  const count = Math.floor(duration / interval);
  const next = normals([BigInt(noise_seed), BigInt(noise_stream)]);
  const times = Float64Array.from({ length: count }, (_, k) => interval * (k + 1));
  const sizes = new Float64Array(angles * count);
  for (let k = 0; k < count; k += 1) {
    for (let i = 0; i < angles; i += 1) {
      sizes[i * count + k] = next() * noise_strength * Math.sqrt(interval);
    }
  }
  return { times, sizes };
}
