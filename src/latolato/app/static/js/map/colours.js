/** Colours of maps, fit for colour-blind eyes and grey print, and which values they stand for. */

import { axisLimits } from "../player/axis.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./chart.js").Look} Look */

// matplotlib's tables at 64 even steps, two hexadecimal digits for each of red, green and blue.
const TABLES = {
  viridis:
    "44015446075a470d6047136548186a481d6f482374482878472d7b46327e453781443b84424086404588" +
    "3e49893d4e8a3a538b38588c365c8d34608d32648e31688e2f6c8e2d708e2c738e2a778e297b8e277f8e" +
    "26828e24868e238a8d218e8d20928c1f968b1f9a8a1f9e891fa18721a58523a98326ad812ab07f2fb47c" +
    "35b7793bbb7542be714ac16d52c5695ac86465cb5e6ece5877d15381d34d8bd64695d840a0da39aadc32" +
    "b5de2bc0df25cae11fd5e21adfe318eae51af4e61efde725",
  cividis:
    "00224e00255400285b002b62002e6a0030700533711235701a386f213b6e273e6e2d416d32436d36466c" +
    "3b496c3f4c6c444f6c48526c4c556c50576c545a6d575d6d5b606e5e636f62656f656870696b716c6e72" +
    "7071737374757777767a7a787e7d788280798683798a86788e8978928c78958f779992779d9576a19975" +
    "a59c74a99f73ada272b1a570b6a96fbaac6dbfb06bc3b369c7b767ccba64d0be62d4c15fd9c55cddc858" +
    "e1cc55e6d051ead34cefd748f3db42f8df3cfde334fee838",
  magma:
    "00000402010903031206051a0a08220e0b2b130d34180f3d1d114722115029115a2f116336106b3d0f71" +
    "440f764a107952137c59157e5f187f651a806b1d81721f817822817e24828426818b2981912b81982d80" +
    "9e2f7fa5317eab337cb2357bba3878c03a76c73d73cd4071d3436ed9466bdf4a68e44f64e95462ed5a5f" +
    "f1605df4675cf66e5cf8765cfa7d5efb8560fc8e64fd9668fe9d6cfea571feac76feb47bfebb81fec287" +
    "feca8dfed194fed89afde0a1fde7a9fceeb0fcf6b8fcfdbf",
};

const STEPS = 256;

const REVERSED = "_r";

/** Names of the colour scales; the last one begins with bright colours. */
export const SCALES = [...Object.keys(TABLES), `viridis${REVERSED}`];

/**
 * Return 256 colours of a scale, dark ones first unless it is reversed, as the 32-bit numbers of a canvas' pixels.
 * @param {string} name
 * @returns {Uint32Array}
 */
export function colourTable(name) {
  const plain = name.replace(REVERSED, "");
  const text = TABLES[/** @type {keyof typeof TABLES} */ (plain)] ?? TABLES.viridis;
  const known = Array.from({ length: text.length / 2 }, (_, i) =>
    parseInt(text.slice(2 * i, 2 * i + 2), 16));
  const count = known.length / 3;
  const shades = new Uint32Array(STEPS);
  for (let i = 0; i < STEPS; i += 1) {
    const place = (i * (count - 1)) / (STEPS - 1);
    const first = Math.min(Math.floor(place), count - 2);
    const share = place - first;
    const [r, g, b] = [0, 1, 2].map((k) =>
      Math.round((1 - share) * known[3 * first + k] + share * known[3 * first + 3 + k]));
    shades[i] = pixel(r, g, b);
  }
  return plain === name ? shades : shades.reverse();
}

/**
 * Return a colour as the 32-bit number of an opaque pixel.
 * @param {number} r
 * @param {number} g
 * @param {number} b
 */
export function pixel(r, g, b) {
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
}

/**
 * Return the pixel of a colour written as #rrggbb.
 * @param {string} text
 */
export function pixelOf(text) {
  const [r, g, b] = [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));
  return pixel(r, g, b);
}

/**
 * Return which variable is shown and how its values become colours.
 * @param {Grid} grid
 * @param {Record<string, string>} extra
 * @returns {Look}
 */
export function lookOf(grid, extra) {
  const name = extra["map.observable"] ?? grid.about.observable;
  const chosen = grid.variable(name, extra["map.ball"] ?? null);
  const variable = Math.max(0, chosen >= 0 ? chosen : grid.variable(name));
  const about = grid.variables[variable];
  const usual = about.log ? "1" : "0";
  const log = (extra["map.log"] ?? usual) === "1" && !about.classes.length;
  const [low, high] = grid.range(variable, log);
  const limit = (/** @type {string} */ key, /** @type {number} */ usual) => {
    const value = Number(extra[key] ?? NaN);
    return Number.isFinite(value) && (!log || value > 0) ? value : usual;
  };
  const [from, to] = [limit("map.low", low), limit("map.high", high)];
  return { variable, scale: extra["map.scale"] ?? about.scale ?? SCALES[0], log,
    limits: from < to ? axisLimits(from, to) : [low, high] };
}
