// Mouse, pen and fingers on the picture.

import { movePicture, turning } from './camera.js';
import { settings } from './settings.js';
import { windowed, windowOf } from './transfer_function.js';

const radiansEachSide = 2.2;  // how far a drag over the shorter side turns the volume

/** From one direction in the picture to another, clockwise. */
const degreesBetween = (a, b) => ((Math.atan2(b[1], b[0]) - Math.atan2(a[1], a[0])) * 180) / Math.PI;

export class Gestures {
  constructor(app, canvas) {
    this.app = app;
    this.canvas = canvas;
    this.fingers = new Map();
    this.mode = null;
    this.cursor = null;  // where the pointer was last, in CSS pixels of the canvas
    const listen = (name, take) => canvas.addEventListener(name, take, { passive: false });
    listen('pointerdown', (event) => this.down(event));
    listen('pointermove', (event) => this.move(event));
    listen('pointerup', (event) => this.up(event));
    listen('pointercancel', (event) => this.up(event));
    listen('wheel', (event) => this.wheel(event));
    listen('dblclick', (event) => app.probe(this.place(event), canvas.id === 'second'));
    listen('contextmenu', (event) => event.preventDefault());
    listen('auxclick', (event) => event.preventDefault());
  }

  place({ offsetX, offsetY }) {
    return [offsetX, offsetY];
  }

  get side() {
    return Math.min(this.canvas.clientWidth, this.canvas.clientHeight);
  }

  /** From the picture's middle, in lengths of the shorter side, as the camera counts. */
  fromMiddle([x, y]) {
    return [(x - 0.5 * this.canvas.clientWidth) / this.side, (y - 0.5 * this.canvas.clientHeight) / this.side];
  }

  modeOf(event) {
    if (event.button === 2) return 'window';
    if (event.button === 1 || event.shiftKey) return 'pan';
    return event.altKey ? 'roll' : 'turn';
  }

  /** As movePicture() of the camera. */
  moveCamera(by) {
    const { scene } = this.app;
    scene.change({ camera: movePicture(scene.state.camera, by) });
  }

  down(event) {
    event.preventDefault();
    this.canvas.focus({ focusVisible: false });
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, this.place(event));
    this.app.film.stop();
    if (this.fingers.size === 1) {
      this.mode = this.modeOf(event);
      this.start = { at: this.place(event), tf: this.app.scene.state?.transfer_function };
      this.app.sender.hold();
      this.canvas.classList.add('busy');
    } else if (this.fingers.size === 2) {
      this.mode = 'pinch';
    }
  }

  up(event) {
    if (!this.fingers.delete(event.pointerId)) return;
    this.mode = null;  // a finger that stays does not turn the volume
    if (this.fingers.size > 0) return;
    this.canvas.classList.remove('busy');
    this.app.sender.release();
  }

  move(event) {
    const now = this.place(event), before = this.fingers.get(event.pointerId);
    this.cursor = now;
    if (!before || !this.mode) return;
    const { scene } = this.app;
    if (!scene.state) return;
    if (this.mode === 'pinch') this.pinch(event.pointerId, now);
    const shift = [now[0] - before[0], now[1] - before[1]];
    this.fingers.set(event.pointerId, now);
    if (shift[0] === 0 && shift[1] === 0) return;
    const radians = shift.map((d) => (d / this.side) * radiansEachSide);
    if (this.mode === 'turn') scene.change({ camera: turning[settings.turning](scene.state.camera, ...radians) });
    if (this.mode === 'pan') this.moveCamera({ shift: shift.map((d) => d / this.side) });
    if (this.mode === 'roll')
      this.moveCamera({ roll: degreesBetween(this.fromMiddle(before), this.fromMiddle(now)) });
    if (this.mode === 'window') this.windowLevel(now);
  }

  /** Right widens the window, up raises the level; each is told from the drag's start. */
  windowLevel(now) {
    const { tf, at } = this.start;
    const factor = 4 ** ((now[0] - at[0]) / this.side);
    const shift = ((at[1] - now[1]) / this.side) * Math.max(windowOf(tf).width, this.app.valueSpan() * 0.1);
    this.app.transfer.edit(windowed(tf, factor, shift));
  }

  /** Two fingers: the points under them stay under them. */
  pinch(moved, now) {
    const [id, other] = [...this.fingers].find(([finger]) => finger !== moved) ?? [];
    if (id === undefined) return;
    const before = this.fingers.get(moved);
    const spread = (p) => [p[0] - other[0], p[1] - other[1]];
    const [a, b] = [spread(before), spread(now)];
    const zoom = Math.max(Math.hypot(...b), 1) / Math.max(Math.hypot(...a), 1);
    this.moveCamera({ at: this.fromMiddle(other), zoom, roll: degreesBetween(a, b) });
    this.fingers.set(moved, now);
  }

  wheel(event) {
    event.preventDefault();
    if (!this.app.scene.state) return;
    this.app.film.stop();
    const pixels = event.deltaY * [1, 16, 400][event.deltaMode];
    const zoom = Math.exp(-pixels * (event.ctrlKey ? 0.01 : 0.0015));
    this.app.sender.pulse();
    this.moveCamera({ at: this.fromMiddle(this.place(event)), zoom });
  }
}
