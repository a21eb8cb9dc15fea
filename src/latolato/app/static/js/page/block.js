/** Blocks of arrays as the server packs them (see `latolato.app.blocks`). */

const TYPES = { f4: Float32Array, f8: Float64Array, i4: Int32Array, u1: Uint8Array };
const LENGTH = 4;

/**
 * @typedef {Float32Array | Float64Array | Int32Array | Uint8Array} Numbers
 * @typedef {{about: Record<string, any>, arrays: Record<string, Numbers>,
 *   shapes: Record<string, number[]>}} Block
 */

/**
 * Return the header and the arrays of a block; arrays of several rows stay one after the other.
 * @param {ArrayBuffer} buffer
 * @returns {Block}
 */
export function unpack(buffer) {
  const view = new DataView(buffer);
  const begin = LENGTH + view.getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, LENGTH, begin - LENGTH));
  const { arrays: entries, ...about } = JSON.parse(text);
  /** @type {Block} */
  const block = { about, arrays: {}, shapes: {} };
  for (const { name, type, shape, offset, first, last } of entries) {
    block.shapes[name] = shape;
    if (type === "even") {
      block.arrays[name] = even(first, last, shape[0]);
      continue;
    }
    const count = shape.reduce((/** @type {number} */ a, /** @type {number} */ b) => a * b, 1);
    block.arrays[name] = new TYPES[/** @type {keyof typeof TYPES} */ (type)](
      buffer, begin + offset, count);
  }
  return block;
}

/**
 * Return a block that lies in another one.
 * @param {Block} block
 * @param {string} name of the array that holds its bytes
 */
export function inner(block, name) {
  return unpack(/** @type {ArrayBuffer} */ (block.arrays[name].slice().buffer));
}

/**
 * Return evenly spaced numbers, the very ones of `numpy.linspace`.
 * @param {number} first
 * @param {number} last
 * @param {number} count
 */
function even(first, last, count) {
  const numbers = new Float64Array(count);
  const step = (last - first) / (count - 1);
  for (let i = 0; i < count; i += 1) numbers[i] = i * step + first;
  numbers[count - 1] = last;
  return numbers;
}

/**
 * Return one row of an array of several.
 * @param {Block} block
 * @param {string} name
 * @param {number} row
 * @returns {Numbers}
 */
export function row(block, name, row) {
  const shape = block.shapes[name];
  const length = shape[shape.length - 1];
  return block.arrays[name].subarray(row * length, (row + 1) * length);
}
