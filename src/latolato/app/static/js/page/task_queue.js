/** Work that can wait for the next moments, and is forgotten when newer work comes. */

export class TaskQueue {
  constructor() {
    this.turn = 0;
  }

  /**
   * Do these tasks one after the other, each in a moment of its own, unless `run` is called again.
   * @param {(() => void)[]} tasks
   */
  run(tasks) {
    this.turn += 1;
    const { turn } = this;
    const queue = tasks.slice();
    const next = () => {
      if (turn !== this.turn) return;
      const task = queue.shift();
      if (!task) return;
      task();
      setTimeout(next);
    };
    // One frame draws what is already done; the next one begins when that is painted.
    requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(next)));
  }
}
