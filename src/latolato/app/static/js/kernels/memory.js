/**
 * The compiled code that Python calls, as WebAssembly: its memory, its records and its calls.
 *
 * There are five modules: `one` runs one ball, `two` runs two balls and points of their maps,
 * `plane_one` and `plane_two` run balls on strings, under a pivot that moves sideways and in air at
 * rest in the room, and points of their maps, `lanes` runs points of maps of one ball. `make kernels`
 * makes them and `layout.json`, which says which kernels they have and what lies where in their memory.
 * For what the names in it mean see `latolato.numerics`.
 */

/**
 * An array in a module's memory, row by row. Its type is `f8`, `i8` (64 bits) or a record's name.
 * @typedef {{at: number, type: string, shape: number[]}} HeldMemory
 * @typedef {{name: string, type: string, dimensions?: number}} Word
 * @typedef {{
 *   records: Record<string, {size: number, fields: Record<string, HeldMemory>}>,
 *   bundles: Record<string, Word[]>, modules: Record<string, string[]>,
 *   observables: Record<string, ObservableLayout>, occasions: string[], shared_needs: string[],
 *   sample_rows: Record<string, number>, rows: {upright: Rows, plane: Rows},
 *   string_rows: Record<string, number>, contact_rows: {count: number, radial: number, ball: number},
 *   ball_rows: string[], contact_kinds: string[], statuses: string[], problems: Problem[],
 *   drives: WrittenDrive[], steppers: Record<string, Weights>,
 *   lanes: Record<string, number>, scratch_contacts: number, largest: number,
 *   contact_limit: number, last_period: number,
 *   steps_per_call: number, most_halvings: number, most_steps_to_repeat: number}} Layout
 *
 * A drive that a page can write: whether lanes may rotate the phase of its cosine, and the limit of its
 * amplitude; see `latolato.physics.drives.base`.
 * @typedef {{name: string, rotates: boolean, amplitude_limit: [string, string] | null}} WrittenDrive
 *
 * What can be wrong with a run; see `latolato.physics.problems`. The first one is that nothing is.
 * @typedef {{name: string, rule: string, way_out: string, values: string[], parameter: string | null,
 *   value: string}} Problem
 *
 * How many rows the samples of a module have, how many contacts an event may need, and what the
 * rows of the pivot are. Rows of what is known of strings are those of the right ball.
 * @typedef {{samples: number, spare: number, pivot: string[]}} Rows
 *
 * An observable with its usual parameters: how many slots each of its variables has, how many ends
 * of drive periods it looks at, all its slots, which variables have no further dimension, whether
 * it belongs to both balls together, to their mirrored motion and to strings, and its callbacks by
 * occasion.
 * @typedef {{parameters: Record<string, number>, dimension: string, angles: number,
 *   widths: Record<string, number>, marks: number, slots: number, needs: string[], plain: string[],
 *   joint: boolean, mirrored: boolean, of_strings: boolean, callbacks: Record<string, string>}} ObservableLayout
 * @typedef {{kicks: number[], drifts: number[], nodes: number[]}} Weights
 */

const ALIGNMENT = 64;
const PAGE = 65536;
// Bytes of a number.
export const WORD = 8;
const VIEWS = { f8: Float64Array, i8: BigInt64Array };

/** @type {(words: number, next: Word) => number} */
const ahead = (words, { dimensions = 0 }) => words + 1 + 2 * dimensions;
/** @param {number[]} shape */
const count = (shape) => shape.reduce((a, b) => a * b, 1);

/** A module with its memory, in which arrays are taken one behind the other. */
export class Kernels {
  /**
   * Return a module that is ready to be called.
   * @param {WebAssembly.Module} module
   * @param {string} name
   * @param {Layout} layout
   */
  static async start(module, name, layout) {
    /** @type {Record<string, any>} */
    const math = {};
    for (const each of WebAssembly.Module.imports(module)) {
      math[each.name] = Math[/** @type {"sin"} */ (each.name)];
    }
    const { exports } = await WebAssembly.instantiate(module, { env: math });
    return new Kernels(exports, layout, name);
  }

  /**
   * @param {Record<string, any>} exports
   * @param {Layout} layout
   * @param {string} name
   */
  constructor(exports, layout, name) {
    const names = layout.modules[name];
    this.exports = exports;
    this.layout = layout;
    this.name = name;
    this.rows = layout.rows[name.startsWith("plane") ? "plane" : "upright"];
    const { memory, kernels } = exports;
    this.top = 0;
    this.clear();
    const places = new Uint32Array(memory.buffer, kernels.value, names.length);
    /** @type {Record<string, number>} What compiled code calls kernels by. */
    this.addresses = Object.fromEntries(names.map((name, i) => [name, places[i]]));
  }

  /**
   * Return the size of a type in bytes.
   * @param {string} type
   */
  size(type) {
    return type in VIEWS ? WORD : this.layout.records[type].size;
  }

  /**
   * Return a new array of zeros. Views of other arrays are lost if the memory must grow.
   * @param {string} type
   * @param {...number} shape
   * @returns {HeldMemory}
   */
  take(type, ...shape) {
    const { memory } = this.exports;
    const at = Math.ceil(this.top / ALIGNMENT) * ALIGNMENT;
    const end = at + count(shape) * this.size(type);
    const missing = end - memory.buffer.byteLength;
    if (missing > 0) memory.grow(Math.ceil(missing / PAGE));
    this.top = end;
    new Uint8Array(memory.buffer, at, end - at).fill(0);
    return { at, type, shape };
  }

  /**
   * Return a copy of numbers in memory.
   * @param {ArrayLike<number>} numbers
   */
  copy(numbers) {
    const held = this.take("f8", numbers.length);
    this.numbers(held).set(numbers);
    return held;
  }

  /**
   * Give an array back, and all that were taken after it.
   * @param {HeldMemory} held
   */
  release(held) {
    this.top = held.at;
  }

  /** Give all arrays back. */
  clear() {
    this.top = this.exports.__heap_base.value;
  }

  /**
   * Return a view of an array of numbers.
   * @param {HeldMemory} held
   * @returns {any}
   */
  numbers({ at, type, shape }) {
    return new VIEWS[/** @type {"f8"} */ (type)](this.exports.memory.buffer, at, count(shape));
  }

  /**
   * Return a view of an array's bytes.
   * @param {HeldMemory} held
   */
  bytes({ at, type, shape }) {
    return new Uint8Array(this.exports.memory.buffer, at, count(shape) * this.size(type));
  }

  /**
   * Return a field of the record with this number, as an array.
   * @param {HeldMemory} held
   * @param {string} path such as `state.angle`, or `bodies.1.rate` for the second of several
   * @param {number} [index]
   * @returns {HeldMemory}
   */
  field({ at, type }, path, index = 0) {
    const place = { at: at + index * this.size(type), type, shape: [1] };
    for (const name of path.split(".")) {
      const number = Number(name);
      if (Number.isInteger(number)) {
        place.at += number * this.size(place.type);
        place.shape = [];
        continue;
      }
      const field = this.layout.records[place.type].fields[name];
      if (!field) throw new Error(`a record of ${place.type} has no field ${name}`);
      place.at += field.at;
      place.type = field.type;
      place.shape = field.shape;
    }
    return place;
  }

  /**
   * Return a view of a field of all records of an array, and the step from one to the next.
   * @param {HeldMemory} records
   * @param {string} path
   * @returns {{numbers: any, step: number, type: string}}
   */
  column(records, path) {
    const field = this.field(records, path);
    const step = this.size(records.type) / WORD;
    const size = Math.max(0, (records.shape[0] - 1) * step + 1);
    return { numbers: this.numbers({ ...field, shape: [size] }), step, type: field.type };
  }

  /**
   * Return a number of a record.
   * @param {HeldMemory} held
   * @param {string} path
   * @param {number} [index]
   */
  get(held, path, index = 0) {
    return Number(this.numbers(this.field(held, path, index))[0]);
  }

  /**
   * Write numbers into a field of a record.
   * @param {HeldMemory} held
   * @param {string} path
   * @param {...number} values
   */
  set(held, path, ...values) {
    const field = this.field(held, path);
    this.numbers(field).set(field.type === "i8" ? values.map(BigInt) : values);
  }

  /**
   * Write the words from which compiled code reads arrays and numbers; see `abi.words_of`.
   * @param {HeldMemory} words
   * @param {string} bundle
   * @param {Record<string, HeldMemory | number>} values by the names that the bundle has in the layout
   */
  fill(words, bundle, values) {
    const integers = new BigInt64Array(this.exports.memory.buffer, words.at);
    const floats = new Float64Array(this.exports.memory.buffer, words.at);
    let at = 0;
    for (const { name, type, dimensions } of this.layout.bundles[bundle]) {
      const value = values[name];
      if (dimensions === undefined) {
        if (typeof value !== "number") throw new TypeError(`${bundle} needs the number ${name}`);
        if (type === "f8") floats[at] = value;
        else integers[at] = BigInt(value);
        at += 1;
        continue;
      }
      if (typeof value !== "object" || value.type !== type || value.shape.length !== dimensions) {
        throw new TypeError(`${bundle} needs ${name} of ${type} in ${dimensions} dimensions`);
      }
      const strides = value.shape.map((_, i) => count(value.shape.slice(i + 1)) * this.size(type));
      for (const word of [value.at, ...value.shape, ...strides]) {
        integers[at] = BigInt(word);
        at += 1;
      }
    }
  }

  /**
   * Return room for the words of a bundle.
   * @param {string} bundle
   */
  words(bundle) {
    return this.take("i8", this.layout.bundles[bundle].reduce(ahead, 0));
  }

  /**
   * Return which of the words of a bundle are the number, or the array, of this name.
   * @param {string} bundle
   * @param {string} name
   */
  place(bundle, name) {
    const all = this.layout.bundles[bundle];
    return all.slice(0, all.findIndex((word) => word.name === name)).reduce(ahead, 0);
  }

  /**
   * Call a kernel with the words of a bundle.
   * @param {string} kernel
   * @param {string} bundle
   * @param {Record<string, HeldMemory | number>} values
   */
  call(kernel, bundle, values) {
    const words = this.words(bundle);
    this.fill(words, bundle, values);
    this.exports[kernel](words.at);
    this.release(words);
  }

  /**
   * Return the table of what observables are shown; see `kernels.callback_table`.
   * @param {[number, string][][]} occasions for each occasion pairs of first slot and kernel
   * @returns {HeldMemory}
   */
  callbacks(occasions) {
    /** @type {number[]} */
    const begins = [];
    /** @type {number[]} */
    const pairs = [];
    for (const occasion of occasions) {
      begins.push(occasions.length + pairs.length);
      for (const [first, name] of occasion) {
        if (!(name in this.addresses)) throw new Error(`this module has no kernel ${name}`);
        pairs.push(this.addresses[name], first);
      }
      pairs.push(0);
    }
    const table = this.take("i8", begins.length + pairs.length);
    this.numbers(table).set([...begins, ...pairs].map(BigInt));
    return table;
  }
}
