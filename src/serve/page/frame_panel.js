// The volumes of a series: which one is shown, and playing them.

import { byId, clamp } from './dom.js';

export class FramePanel {
  constructor(app) {
    this.app = app;
    this.timer = 0;
    this.playing = false;
    this.seen = 0;  // the frame of the last picture
    const slider = byId('frame');
    slider.addEventListener('input', () => {
      this.stop();
      app.sender.pulse();
      this.go(slider.valueAsNumber);
    });
    byId('frame-play').addEventListener('click', () => this.toggle());
  }

  begin() {
    this.stop();
    byId('series').hidden = this.count < 2;
    byId('frame').max = this.count - 1;
    byId('frame-words').textContent = '';
    this.refresh();
  }

  get names() {
    return this.app.hello.frames;
  }
  get count() {
    return this.names.length;
  }
  get frame() {
    return this.app.scene.state?.frame ?? 0;
  }
  get rate() {
    return clamp(byId('frame-rate').valueAsNumber || 5, 0.1, 60);
  }

  go(frame) {
    if (this.count > 1) this.app.scene.change({ frame: clamp(Math.round(frame), 0, this.count - 1) });
  }

  step(by) {
    this.stop();
    this.go(this.frame + by);
  }

  toggle() {
    if (this.playing) return void this.stop();
    if (this.count < 2 || !this.app.mayEdit()) return;
    this.app.film.stop();
    this.playing = true;
    byId('frame-play').setAttribute('aria-pressed', 'true');
    this.app.sender.hold();
    this.seen = this.frame;
    this.next();
  }

  stop() {
    if (!this.playing) return;
    this.playing = false;
    clearTimeout(this.timer);
    this.timer = 0;
    byId('frame-play').setAttribute('aria-pressed', 'false');
    this.app.sender.release();
  }

  /** The next frame, not before the present one has been seen; the first follows the last. */
  next() {
    this.timer = setTimeout(() => {
      this.timer = 0;
      if (this.seen === this.frame) this.advance();
    }, 1000 / this.rate);
  }

  advance() {
    this.go((this.frame + 1) % this.count);
    this.next();
  }

  pictureShown() {
    if (this.count < 2) return;
    this.seen = this.frame;
    byId('frame-words').textContent = '';
    if (this.playing && !this.timer) this.advance();
  }

  told({ frame, status }) {
    byId('frame-words').textContent = status === 'loading' ? `loading ${this.names[frame]}` : '';
    if (status !== 'failed') return;
    this.stop();
    if (this.app.driving && frame === this.frame) this.go(this.seen);
    if (this.app.driving && frame === this.app.compare.choice.compare) this.app.adjust({ compare: null });
  }

  refresh() {
    const slider = byId('frame'), name = this.names[this.frame];
    slider.value = this.frame;
    slider.setAttribute('aria-valuetext', `${name}, ${this.frame + 1} of ${this.count}`);
    byId('frame-name').textContent = `${name} (${this.frame + 1} of ${this.count})`;
  }
}
