/** What the page asks the server. */

import { InputError } from "../model/rules.js";
import { unpack } from "./block.js";

/** @typedef {import("../model/rules.js").Sentence} Sentence */
/**
 * Refused input, see `latolato.core.errors.InputError.parts`.
 * @typedef {{rule: string | Sentence, parameter: string | null, where?: string, value?: any,
 *   way_out?: string | Sentence}} Parts
 */

/**
 * Return the error of refused input.
 * @param {Parts} parts
 */
export function inputError({ rule, parameter, where, way_out: wayOut, ...more }) {
  return new InputError(rule, { ...(parameter !== null && { parameter }), ...(where && { where }),
    ...("value" in more && { value: more.value }), ...(wayOut && { wayOut }) });
}

/** A request that the server refused, with one line that says why. */
export class Refusal extends Error {
  /**
   * @param {string} message
   * @param {string | null} [field] the option that it is about
   * @param {Parts | null} [parts] of refused input
   */
  constructor(message, field = null, parts = null) {
    super(message);
    this.field = field;
    /** What the page says about it in its own words, where it can. */
    this.input = parts && inputError(parts);
  }
}

/** A request that never reached the server: it is down, or being started again. */
export class Offline extends Error {}

/**
 * The server's response to JSON; a refused request throws a Refusal.
 * @param {string} path
 * @param {any} [body] without it the request is a GET
 * @param {AbortSignal} [signal]
 * @returns {Promise<Response>}
 */
export async function ask(path, body, signal) {
  const options = body === undefined ? {} : {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(body),
  };
  const response = await fetch(path, { ...options, signal }).catch((error) => {
    throw error instanceof TypeError ? new Offline(error.message) : error;
  });
  if (response.ok) return response;
  const refusal = await response.json().catch(() => ({ error: response.statusText }));
  throw new Refusal(refusal.error, refusal.field, refusal.parts);
}

/**
 * Return the JSON of an address.
 * @param {string} path
 * @param {any} [body]
 * @returns {Promise<any>}
 */
export async function askJson(path, body) {
  return (await ask(path, body)).json();
}

/**
 * Return a block of arrays.
 * @param {string} path
 * @param {any} [body]
 * @param {AbortSignal} [signal]
 */
export async function askBlock(path, body, signal) {
  return unpack(await (await ask(path, body, signal)).arrayBuffer());
}

/**
 * Return the address of a WebSocket of this server.
 * @param {string} path
 */
export function socketAddress(path) {
  const address = new URL(path, document.baseURI);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  return address.href;
}

/**
 * End a WebSocket, also one that has only been asked for: browsers complain of closing those.
 * @param {WebSocket | null | undefined} socket
 */
export function hangUp(socket) {
  if (!socket) return;
  if (socket.readyState === WebSocket.CONNECTING)
    socket.addEventListener("open", () => socket.close(), { once: true });
  else socket.close();
}
