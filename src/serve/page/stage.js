// The picture's canvas: shows what the server sent, moved, zoomed and rolled to the present camera until the
// picture of that camera comes.

import { differenceOf } from './compare_panel.js';
import { byId, toHex, onceAFrame } from './dom.js';

const mostRemembered = 512;

export class Stage {
  constructor(app) {
    this.app = app;
    this.canvas = byId('picture');
    this.contexts = [this.canvas, byId('second')].map((canvas) => canvas.getContext('2d', { alpha: false }));
    this.shown = null;  // the bitmap on the canvas, or those on both, and what they show
    this.sent = new Map();
    this.largest = 4096;
    this.draw = onceAFrame(() => this.drawNow());
    const exact = 'devicePixelContentBoxSize' in ResizeObserverEntry.prototype;
    new ResizeObserver(([entry]) => {
      const box = exact ? entry.devicePixelContentBoxSize[0] : null;
      this.box = { width: entry.contentRect.width, height: entry.contentRect.height,
                   columns: box?.inlineSize, rows: box?.blockSize };
      this.measure();
    }).observe(this.canvas, { box: exact ? 'device-pixel-content-box' : 'content-box' });
    this.watchRatio();
  }

  measure() {
    if (!this.box) return;
    const ratio = window.devicePixelRatio || 1, { width, height, columns, rows } = this.box;
    // The exact size, unless it leaves out a ratio that is only emulated.
    const pixels = (exactly, css) => (Math.abs(exactly - css * ratio) < 2 ? exactly : Math.round(css * ratio));
    this.place = [pixels(columns, width), pixels(rows, height)];
    this.resize();
    this.app.resized();
  }

  /** The window may come to a screen with other pixels. */
  watchRatio() {
    matchMedia(`(resolution: ${window.devicePixelRatio || 1}dppx)`).addEventListener('change', () => {
      this.measure();
      this.watchRatio();
    }, { once: true });
  }

  /** To its place, but no larger than the server draws. */
  resize() {
    if (!this.place) return;
    const [width, height] = this.place;
    const scale = Math.min(1, this.largest / Math.max(width, height));
    const size = [width, height].map((n) => Math.max(1, Math.round(n * scale)));
    if (this.canvas.width === size[0] && this.canvas.height === size[1]) return;
    for (const { canvas } of this.contexts) [canvas.width, canvas.height] = size;
    this.draw();
  }

  /** Pixels of the canvas for each CSS pixel. */
  get pixelsEach() {
    return this.canvas.width / Math.max(1, this.canvas.clientWidth);
  }

  /** The picture's size that watchers and drivers see, and where it lies on the canvas. */
  fit() {
    const { width, height } = this.canvas;
    if (this.app.driving || !this.shown) return { width, height, scale: 1, left: 0, top: 0 };
    const scale = Math.min(width / this.shown.width, height / this.shown.height);
    return { width: this.shown.width, height: this.shown.height, scale,
             left: 0.5 * (width - scale * this.shown.width), top: 0.5 * (height - scale * this.shown.height) };
  }

  /** Remembers camera and volumes of a view that was sent, to know what its picture shows. */
  remember(seq, { camera, frame, compare }) {
    this.sent.set(seq, { camera, frame, compare, width: this.canvas.width, height: this.canvas.height });
    if (this.sent.size > mostRemembered) this.sent.delete(this.sent.keys().next().value);
  }

  /** Numbers of views begin anew: another page drives, or the connection is new. */
  forget() {
    this.sent.clear();
    if (this.shown) this.shown.seq = -1;
  }

  isStale(head) {
    const last = this.shown;
    if (this.app.driving && !this.sent.has(head.seq)) return last !== null;  // of another page's view
    return last !== null && last.seq >= 0 &&
           (head.seq < last.seq || (head.seq === last.seq && head.level < last.level));
  }

  /** Decodes and shows a view's picture, or its two, unless a newer one is there. */
  async take(head) {
    if (this.isStale(head)) return;
    let bitmaps;
    try {
      bitmaps = await Promise.all(Array.from({ length: head.pictures }, (_, k) => createImageBitmap(
        head.blob, 0, k * head.height, head.width, head.height, { colorSpaceConversion: 'none' })));
    } catch {
      return;
    }
    if (this.isStale(head)) return bitmaps.forEach((bitmap) => bitmap.close());
    this.shown?.bitmaps.forEach((bitmap) => bitmap.close());
    const asked = this.sent.get(head.seq) ?? { camera: null, width: head.width, height: head.height };
    const own = !this.app.driving || this.sent.has(head.seq);
    this.shown = { ...asked, bitmaps, exact: head.blob.type === 'image/png', seq: own ? head.seq : -1, level: head.level };
    this.draw();
    this.app.pictureShown(head, performance.now() - head.time);
  }

  drawNow() {
    const { shown } = this, { scene: { state }, compare } = this.app;
    if (!state) return;
    const { beside, gain } = compare.choice;
    if (gain && shown?.bitmaps.length > 1 && shown.difference?.gain !== gain)
      shown.difference = differenceOf(shown.bitmaps, gain);
    const difference = gain ? shown?.difference : undefined;
    this.put(this.contexts[0], difference?.canvas ?? shown?.bitmaps[0]);
    if (beside) this.put(this.contexts[1], shown?.bitmaps[1]);
    compare.name(shown, difference);
  }

  put(context, bitmap) {
    const { canvas, shown } = this, { driving, scene: { state } } = this.app;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = toHex(state.background);
    context.fillRect(0, 0, canvas.width, canvas.height);
    if (!bitmap) return;
    if (driving && shown.camera) this.preview(context, shown, state.camera);
    else {
      const { scale, left, top } = this.fit();
      context.setTransform(scale, 0, 0, scale, left, top);
    }
    context.imageSmoothingQuality = 'high';
    context.drawImage(bitmap, 0, 0, shown.width, shown.height);
  }

  /** Pan, zoom and roll are exact transforms of the picture, in perspective too. */
  preview(context, shown, camera) {
    const { canvas } = this;
    const old = shown.camera, oldSide = Math.min(shown.width, shown.height);
    const side = Math.min(canvas.width, canvas.height);
    const sameDirection = old.azimuth === camera.azimuth && old.elevation === camera.elevation;
    const scale = (camera.zoom / old.zoom) * (side / oldSide);
    context.translate(0.5 * canvas.width + camera.pan[0] * side, 0.5 * canvas.height + camera.pan[1] * side);
    if (sameDirection) context.rotate(((camera.roll - old.roll) * Math.PI) / 180);
    context.scale(scale, scale);
    context.translate(-(0.5 * shown.width + old.pan[0] * oldSide), -(0.5 * shown.height + old.pan[1] * oldSide));
  }
}
