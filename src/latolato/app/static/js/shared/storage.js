/** Recordings, kept in the browser's own database: the newest, up to a number and a size. */

/** @typedef {import("./block.js").Block} Block */
/**
 * What is listed of a recording: when it was made [ms since 1970], how long it is [s], its size, and
 * the options of the run that it is, null if it is none.
 * @typedef {{id: string, created: number, duration: number, bytes: number,
 *   options: Record<string, string> | null}} Entry
 */

export const MOST_KEPT = 20;
export const MOST_BYTES = 50e6;
const DATABASE = "latolato";
const VERSION = 1;
// Entries are listed without loading their blocks.
const ENTRIES = "recordings";
const BLOCKS = "blocks";

/**
 * The result of a request to the database.
 * @template T
 * @param {IDBRequest<T>} request
 * @returns {Promise<T>}
 */
function answer(request) {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}

/**
 * Return when a transaction is written.
 * @param {IDBTransaction} transaction
 * @returns {Promise<void>}
 */
function written(transaction) {
  return new Promise((resolve, reject) => {
    transaction.oncomplete = () => resolve();
    transaction.onabort = () => reject(transaction.error);
  });
}

export class Shelf {
  /** @param {IDBFactory | undefined} factory browsers may refuse one, or have none */
  constructor(factory) {
    this.factory = factory;
    /** @type {Promise<IDBDatabase | null> | null} */
    this.opening = null;
    /** Of those that the browser does not keep, until the page is left.
     * @type {Map<string, {entry: Entry, block: Block}>} */
    this.unkept = new Map();
  }

  /** Return the database, null where the browser has none for this page. */
  open() {
    this.opening ??= (async () => {
      try {
        const request = /** @type {IDBFactory} */ (this.factory).open(DATABASE, VERSION);
        request.onupgradeneeded = () => {
          for (const name of [ENTRIES, BLOCKS]) request.result.createObjectStore(name);
        };
        const database = await answer(request);
        // Another page may need a newer version, or the data of the page may be cleared: then open it again.
        database.onversionchange = () => {
          database.close();
          this.opening = null;
        };
        database.onclose = () => { this.opening = null; };
        return database;
      } catch {
        return null;
      }
    })();
    return this.opening;
  }

  /**
   * Return all entries, the newest first.
   * @returns {Promise<Entry[]>}
   */
  async list() {
    const database = await this.open();
    const kept = database
      ? await answer(database.transaction(ENTRIES).objectStore(ENTRIES).getAll()) : [];
    const all = [...kept, ...[...this.unkept.values()].map(({ entry }) => entry)];
    return all.sort((one, other) => other.created - one.created);
  }

  /**
   * Keep a recording, and let the oldest go that have no room beside it. Returns its entry, whether
   * the browser keeps it, and how many went.
   * @param {Omit<Entry, "id" | "bytes">} about
   * @param {Block} block
   */
  async put(about, block) {
    const bytes = Object.values(block.arrays).reduce((sum, { byteLength }) => sum + byteLength, 0);
    const entry = { ...about, id: Date.now().toString(36), bytes };
    const before = await this.list();
    while (before.some(({ id }) => id === entry.id)) entry.id += "a";
    let room = MOST_BYTES - bytes;
    const gone = before.filter((each, i) => {
      room -= each.bytes;
      return i + 1 >= MOST_KEPT || room < 0;
    });
    try {
      const database = await this.open();
      if (!database) throw new DOMException("", "InvalidStateError");
      const transaction = database.transaction([ENTRIES, BLOCKS], "readwrite");
      transaction.objectStore(ENTRIES).put(entry, entry.id);
      transaction.objectStore(BLOCKS).put(block, entry.id);
      await written(transaction);
    } catch (error) {
      if (!(error instanceof DOMException)) throw error;
      this.unkept.set(entry.id, { entry, block });
      return { entry, isKept: false, gone: 0 };
    }
    for (const { id } of gone) await this.remove(id);
    return { entry, isKept: true, gone: gone.length };
  }

  /**
   * Return a recording, null if it is not here.
   * @param {string} id
   * @returns {Promise<Block | null>}
   */
  async block(id) {
    const unkept = this.unkept.get(id);
    if (unkept) return unkept.block;
    const database = await this.open();
    if (!database) return null;
    return await answer(database.transaction(BLOCKS).objectStore(BLOCKS).get(id)) ?? null;
  }

  /** @param {string} id */
  async remove(id) {
    if (this.unkept.delete(id)) return;
    const database = await this.open();
    if (!database) return;
    const transaction = database.transaction([ENTRIES, BLOCKS], "readwrite");
    for (const name of [ENTRIES, BLOCKS]) transaction.objectStore(name).delete(id);
    await written(transaction);
  }
}

/** Return the browser's database; some throw where they refuse it. */
function factory() {
  try {
    return globalThis.indexedDB;
  } catch {
    return undefined;
  }
}

/** The one shelf of the page. */
export const shelf = new Shelf(factory());
