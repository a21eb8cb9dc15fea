/** The way to a toy on the server: messages with numbers, frames, and coming back after a break. */

import { hangUp, socketAddress } from "../api.js";

/**
 * One frame by the names that the server announced.
 * @typedef {Record<string, number>} Frame
 */

// A page acknowledges this often, in frames; to one that is a second behind none are sent.
const ACK_EVERY = 6;
const FIRST_WAIT = 250; // ms
const LONGEST_WAIT = 4000; // ms

export class Link {
  /**
   * @param {{hello: () => any, ready: (about: any) => void, frame: (frame: Frame) => void,
   *   error: (text: string, field: string | null) => void, recorded: (about: any) => void,
   *   connected: (is: boolean) => void}} on `hello` says what to greet with, every time
   */
  constructor(on) {
    this.on = on;
    this.seq = 0;
    /** @type {WebSocket | null} */
    this.socket = null;
    /** @type {string[]} */
    this.names = [];
    this.isReady = false;
    this.wait = FIRST_WAIT;
    this.timer = 0;
    this.closed = false;
  }

  open() {
    this.close();
    this.closed = false;
    const socket = new WebSocket(socketAddress("ws/live"));
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      if (socket === this.socket) socket.send(JSON.stringify({ hello: this.on.hello() }));
    };
    socket.onmessage = ({ data }) => {
      if (socket !== this.socket) return;
      if (typeof data === "string") this.read(JSON.parse(data));
      else this.see(new Float64Array(data));
    };
    socket.onclose = () => {
      if (socket !== this.socket || this.closed) return;
      this.isReady = false;
      this.on.connected(false);
      this.timer = window.setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    };
  }

  /** @param {any} message */
  read(message) {
    if (message.ready) {
      this.names = message.ready.frame;
      this.isReady = true;
      this.wait = FIRST_WAIT;
      this.on.connected(true);
      this.on.ready(message.ready);
    } else if (message.recorded) this.on.recorded(message.recorded);
    else if (message.error) this.on.error(message.error, message.field ?? null);
  }

  /** @param {Float64Array} numbers */
  see(numbers) {
    /** @type {Frame} */
    const frame = {};
    for (let k = 0; k < this.names.length; k += 1) frame[this.names[k]] = numbers[k];
    if (frame.number % ACK_EVERY === 0) this.post({ ack: frame.number });
    this.on.frame(frame);
  }

  /**
   * Return the number under which a message was sent; frames from then on know it.
   * @param {Record<string, any>} message
   */
  send(message) {
    this.seq += 1;
    this.post({ seq: this.seq, ...message });
    return this.seq;
  }

  /** @param {any} message */
  post(message) {
    if (this.isReady && this.socket?.readyState === WebSocket.OPEN)
      this.socket.send(JSON.stringify(message));
  }

  close() {
    clearTimeout(this.timer);
    this.closed = true;
    this.isReady = false;
    hangUp(this.socket);
    this.socket = null;
  }
}

/**
 * Return what a frame holds that a toy can go on from.
 * @param {Frame} frame
 * @param {number} angles how many the system has
 */
export function stateOf(frame, angles) {
  const { time, phase, drive_amplitude, drive_frequency } = frame;
  return {
    time, phase, drive_amplitude, drive_frequency,
    angles: [frame.angle_1, frame.angle_2].slice(0, angles),
    velocities: [frame.velocity_1, frame.velocity_2].slice(0, angles),
  };
}
