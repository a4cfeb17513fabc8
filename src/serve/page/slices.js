// Three slices beside the volume, one across each axis of its lattice, or one across the view instead of the last, and
// the voxel where they meet: each shows where that is, and has the window and colours of the transfer function.

import { placeOf, sum, viewOf } from './camera.js';
import { byId, clamp, toHex, element, fitCanvas, onDrag, onKeys, onceAFrame, show } from './dom.js';
import { ink, strokeTwice, trace, write } from './overlay.js';
import { onSettings, settings } from './settings.js';
import { showError } from './status.js';

const names = ['x', 'y', 'z'], shownBy = ['transfer_function', 'channels', 'tints', 'mode', 'frame', 'background'];
const restBegins = 150;  // milliseconds without a move, until the value is asked for

/** The slice across one axis: its picture, asked for anew when it is out of date, and its gestures. */
class Pane {
  constructor(slices, axis, name = `across ${names[axis]}`) {
    this.slices = slices;
    this.axis = axis;
    const keys = 'Arrow keys move the point, page up and page down the slice, Enter puts an end of the ruler there.';
    this.canvas = element('canvas', { tabindex: 0, role: 'application', 'aria-label': `Slice ${name}. ${keys}` });
    this.draw = onceAFrame(() => this.drawNow());
    new ResizeObserver(() => this.ask()).observe(this.canvas);
    const { app } = slices, move = (event) => this.point(event.offsetX, event.offsetY);
    onDrag(app, this.canvas, { begin: move, move });
    this.canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.go(0, 0, Math.sign(event.deltaY));
    }, { passive: false });
    this.canvas.addEventListener('dblclick', () => slices.mark());
    onKeys(app, this.canvas, {
      ArrowRight: () => this.go(1, 0, 0), ArrowLeft: () => this.go(-1, 0, 0), ArrowUp: () => this.go(0, 1, 0),
      ArrowDown: () => this.go(0, -1, 0), PageUp: () => this.go(0, 0, 1), PageDown: () => this.go(0, 0, -1),
      Enter: () => slices.mark() });
  }

  /** Moves the voxel to the right, up, or to another slice. */
  go(right, up, across) {
    const at = [...this.slices.at], { lies } = this;
    for (const [code, way] of [[lies.right, right], [lies.up, up], [this.axis + 1, across]])
      at[Math.abs(code) - 1] += way * Math.sign(code);
    this.slices.goTo(at);
  }
  /** Whether another voxel lies in another slice. */
  differs(at, before) {
    return at[this.axis] !== before[this.axis];
  }

  /** The lattice axes that point right and up, 1 to 3, negative where they point the other way. */
  get lies() {
    return this.slices.volume.slices[this.axis];
  }

  /** Where the slice lies on the canvas, in CSS pixels. */
  place() {
    const { volume } = this.slices, { clientWidth, clientHeight } = this.canvas;
    const extent = (code) => volume.dims[Math.abs(code) - 1] * volume.spacing[Math.abs(code) - 1];
    const [across, high] = [extent(this.lies.right), extent(this.lies.up)];
    const scale = Math.min(clientWidth / across, clientHeight / high), [width, height] = [across * scale, high * scale];
    return { left: 0.5 * (clientWidth - width), top: 0.5 * (clientHeight - height), width, height };
  }

  /** How far right or down a voxel's middle lies, as a part of the slice. */
  part(code, down) {
    const k = Math.abs(code) - 1, part = (this.slices.at[k] + 0.5) / this.slices.volume.dims[k];
    return (code < 0) !== down ? 1 - part : part;
  }

  /** Where the voxel is seen on the canvas. */
  cross() {
    const { left, top, width, height } = this.place();
    return [left + width * this.part(this.lies.right, false), top + height * this.part(this.lies.up, true)];
  }

  point(x, y) {
    const { left, top, width, height } = this.place(), { lies } = this, { volume } = this.slices;
    const at = [...this.slices.at];
    for (const [code, part] of [[lies.right, (x - left) / width], [lies.up, 1 - (y - top) / height]]) {
      const k = Math.abs(code) - 1;
      at[k] = (code < 0 ? 1 - part : part) * volume.dims[k] - 0.5;
    }
    this.slices.goTo(at);
  }

  /** What the server is asked for: this slice as it is, in the canvas's pixels. */
  question() {
    const { width, height } = this.place(), ratio = window.devicePixelRatio || 1, most = this.slices.app.hello.largest;
    const [columns, rows] = [width, height].map((side) => clamp(Math.round(side * ratio), 1, most));
    return { width: columns, height: rows, state: this.slices.state(), slice: this.slice() };
  }
  slice() {
    return [this.axis, this.slices.at[this.axis]];
  }
  says() {
    return `${names[this.axis]} ${this.slices.at[this.axis]}`;
  }

  async ask() {
    if (!this.slices.shown || this.canvas.clientWidth < 2) return;
    this.stale = this.asks;
    if (this.asks) return;
    this.asks = true;
    try {
      const { blob } = await this.slices.app.connection.ask({ type: 'snapshot', format: 'png', ...this.question() });
      this.bitmap = await createImageBitmap(blob, { colorSpaceConversion: 'none' });
    } catch (error) {
      showError(`The slice could not be drawn: ${error.message}`);
    }
    this.asks = false;
    this.draw();
    if (this.stale) this.ask();
  }

  drawNow() {
    const { context, width, height } = fitCanvas(this.canvas), { app, words } = this.slices;
    const { background } = app.scene.state, place = this.place(), colours = ink(background);
    context.fillStyle = toHex(background);
    context.fillRect(0, 0, width, height);
    context.imageSmoothingEnabled = false;
    if (this.bitmap) context.drawImage(this.bitmap, place.left, place.top, place.width, place.height);
    const [x, y] = this.cross(), gap = 6;
    trace(context, [[place.left, y], [x - gap, y]], [[x + gap, y], [place.left + place.width, y]],
          [[x, place.top], [x, y - gap]], [[x, y + gap], [x, place.top + place.height]]);
    context.globalAlpha = 0.6;
    strokeTwice(context, colours);
    context.globalAlpha = 1;
    context.font = '12px system-ui, sans-serif';
    const told = [this.says(), ...(this.axis === 2 ? words : [])];
    told.forEach((line, k) => write(context, colours, line, 10, 20 + 16 * k));
  }
}

/** The slice across the view, as it is turned, through the voxel. */
class ViewPane extends Pane {
  constructor(slices) {
    super(slices, -1, 'across the view');
  }
  place() {
    return { left: 0, top: 0, width: this.canvas.clientWidth, height: this.canvas.clientHeight };
  }
  /** How the server shows it: whole, in the middle. */
  seen() {
    const { width, height } = this.place(), { app, volume } = this.slices;
    return viewOf({ ...app.scene.state.camera, zoom: 1, pan: [0, 0], fov: 0 }, volume, width, height);
  }
  cross() {
    return this.seen().project(this.slices.at);
  }
  /** Moves it by pixels and by its depth. */
  shift(right, up, near) {
    const { slices } = this, seen = this.seen(), [x, y, depth] = seen.project(slices.at);
    slices.goTo(placeOf(slices.volume, sum([(x - seen.centre[0] + right) / seen.pixelsPerUnit, seen.right],
                                           [(seen.centre[1] - y + up) / seen.pixelsPerUnit, seen.up], [depth + near, seen.viewer])));
  }
  point(x, y) {
    const [from, down] = this.cross();
    this.shift(x - from, down - y, 0);
  }
  go(right, up, across) {
    const far = 1.8 * Math.max(...this.slices.volume.spacing);  // another voxel in any direction
    const pixels = far * this.seen().pixelsPerUnit;
    this.shift(right * pixels, up * pixels, across * far);
  }
  differs() {
    return true;
  }
  slice() {
    return this.slices.at;
  }
  says() {
    return 'across the view';
  }
}

export class Slices {
  constructor(app) {
    this.app = app;
    this.at = [0, 0, 0];  // voxel
    this.words = [];  // of the voxel
    this.panes = [...[2, 1, 0].map((axis) => new Pane(this, axis)), new ViewPane(this)];
    byId('slices').append(...this.panes.map(({ canvas }) => canvas));
    onSettings(() => [2, 3].forEach((k) => { this.panes[k].canvas.hidden = settings.oblique !== (k === 3); }));
    byId('cut').addEventListener('change', ({ target: { value } }) => {
      app.scene.change({ cut: value === '' ? null : [Number(value), ...this.at] });
      this.refresh();
    });
    byId('cut-place').addEventListener('input', ({ target }) => {
      app.sender.pulse();
      this.goTo(this.at.with(this.cut, target.valueAsNumber));
    });
  }

  get volume() {
    return this.app.volume;
  }
  /** Where the volume is cut open: along an axis' slices, across the view (3), or nowhere. */
  get cut() {
    return this.app.scene.state.cut?.[0];
  }
  get shown() {
    return settings.slices && this.app.scene.state !== null;
  }

  /** The scene that slices are of: one whose colours are those of values, not of sums along rays. */
  state() {
    const { state } = this.app.scene, { hello } = this.app;
    if (state.mode !== 'sum') return state;
    const channels = state.channels.map((one, k) => ({ ...one, window: hello.channels[k].windows.mip }));
    return { ...state, transfer_function: hello.modes.mip, channels };
  }

  /** In the middle at first; after a lost connection the slices stay where they were. */
  begin(resumes) {
    this.at = this.nearest(resumes ? this.at : this.volume.dims.map((count) => 0.5 * (count - 1)));
    this.words = [];
    this.looks = '';
  }

  /** Asks anew where the scene looks otherwise; what turns the volume changes only the slice across the view. */
  refresh() {
    if (this.cut !== undefined) this.goTo(this.app.scene.state.cut.slice(1));
    const { state } = this.app.scene, { azimuth, elevation, roll } = state.camera;
    const looks = JSON.stringify(shownBy.map((key) => state[key])), view = [azimuth, elevation, roll].join();
    if (looks !== this.looks) this.ask();
    else if (view !== this.view) this.panes[3].ask();
    [this.looks, this.view] = [looks, view];
    byId('cut').value = this.cut ?? '';
    const place = byId('cut-place');
    place.hidden = !(this.cut < 3);
    if (!place.hidden) Object.assign(place, { max: this.volume.dims[this.cut] - 1, value: this.at[this.cut] });
  }

  ask() {
    for (const pane of this.panes) pane.ask();
  }

  nearest(place) {
    return place.map((v, k) => clamp(Math.round(v), 0, this.volume.dims[k] - 1));
  }

  /** Has the slices meet at the voxel that is nearest. */
  goTo(place) {
    const at = this.nearest(place), before = this.at;
    if (at.every((v, k) => v === before[k])) return;
    [this.at, this.words] = [at, []];
    if (this.cut !== undefined) this.app.scene.change({ cut: [this.cut, ...at] });
    for (const pane of this.panes) {
      if (pane.differs(at, before)) pane.ask();
      pane.draw();
    }
    this.app.redraw();
    clearTimeout(this.timer);
    if (this.shown) this.timer = setTimeout(() => this.askValue(), restBegins);
  }

  /** Puts an end of the ruler where the slices meet. */
  mark() {
    this.app.probing.mark(this.at);
    this.askValue();
  }

  /** Tells the value of the voxel where the slices meet. */
  async askValue() {
    const { at } = this;
    try {
      const { value } = await this.app.connection.ask({ type: 'probe', voxel: at, state: this.state() });
      if (at !== this.at) return;
      const { probing } = this.app, measures = probing.places.at(-1) === at ? probing.measures() : [];
      this.words = [`value ${show(value, 6)}`, ...measures];
      byId('probe-words').textContent = [`voxel ${at.join(', ')}`, ...this.words].join('; ');
      this.panes[0].draw();
    } catch {
      // a later one was asked for
    }
  }

  /** The slices' outlines as boxes, for what is drawn over the volume. */
  boxes() {
    if (!this.shown) return [];
    const whole = this.volume.dims.map((count) => [0, count]);
    const boxes = this.at.map((place, axis) => whole.with(axis, [place + 0.5, place + 0.5]));
    return settings.oblique ? boxes.slice(1) : boxes;
  }
}
