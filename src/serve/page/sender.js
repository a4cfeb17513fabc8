// Sends the scene to the server: at most one view before each of the screen's frames, told whether a gesture
// goes on.

import { onceAFrame } from './dom.js';

const restAfter = 150;  // milliseconds after the last turn of a wheel, key or slider

export class Sender {
  /** `write({seq, moving})` sends the view; false when it could not. */
  constructor(write) {
    this.request = onceAFrame(() => {
      if (write({ seq: this.seq + 1, moving: this.moving })) ++this.seq;
    });
    this.seq = Math.floor(Math.random() * 2 ** 30);  // so that pages do not take each other's pictures for theirs
    this.held = 0;
    this.timer = 0;
  }

  get moving() {
    return this.held > 0 || this.timer !== 0;
  }

  /** A drag begins, and ends. */
  hold() {
    ++this.held;
  }
  release() {
    if (this.held > 0 && --this.held === 0 && !this.timer) this.request();
  }

  /** Something moves that does not say when it ends. */
  pulse() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.timer = 0;
      if (!this.moving) this.request();
    }, restAfter);
  }
}
