// The two canvases of the transfer function's editor: opacity points over the histogram, and colour stops below.

import { byId, clamp, toHex, fitCanvas, onDrag, onKeys, themeColour } from './dom.js';
import { trace } from './overlay.js';
import { settings } from './settings.js';
import { addColours, canLose, colourAt, opacityAt, withPoint, withPointAt } from './transfer_function.js';

const near = 9, top = 10, bottom = 4, side = 8;  // pixels

export class CurveEditor {
  /** `app.transfer.edit(tf)` shows a change, `app.commit()` ends it for undo. */
  constructor(app, onSelect) {
    this.app = app;
    this.onSelect = onSelect;
    this.selected = { which: 'opacities', index: 0 };
    for (const [id, which] of [['curve', 'opacities'], ['strip', 'colours']]) {
      const canvas = byId(id);
      onDrag(app, canvas, { begin: (event) => this.take(event, canvas, which),
                            move: (event) => this.move(event, canvas), end: () => app.commit() });
      canvas.addEventListener('contextmenu', (event) => {
        event.preventDefault();
        const index = this.indexAt(event, canvas, which);
        if (index >= 0) this.remove(which, index);
      });
      onKeys(app, canvas, this.keys(which));
      new ResizeObserver(() => this.draw()).observe(canvas);
    }
  }

  get tf() {
    return this.app.scene.state.transfer_function;
  }
  get point() {
    return this.tf[this.selected.which][this.selected.index];
  }

  select(which, index) {
    this.selected = { which, index: clamp(index, 0, this.tf[which].length - 1) };
    this.draw();
    this.onSelect();
  }

  x(value, width) {
    const [low, high] = this.app.valueRange();
    return side + clamp((value - low) / (high - low), 0, 1) * (width - 2 * side);
  }
  y(opacity, height) {
    return top + (1 - opacity) * (height - top - bottom);
  }
  valueAt({ offsetX, offsetY }, { clientWidth, clientHeight }) {
    const [low, high] = this.app.valueRange();
    const value = low + ((offsetX - side) / (clientWidth - 2 * side)) * (high - low);
    const opacity = 1 - (offsetY - top) / (clientHeight - top - bottom);
    return [clamp(value, low, high), clamp(opacity, 0, 1)];
  }

  indexAt({ offsetX, offsetY, pointerType }, { clientWidth, clientHeight }, which) {
    const distances = this.tf[which].map((p) => Math.hypot(
      this.x(p[0], clientWidth) - offsetX, which === 'opacities' ? this.y(p[1], clientHeight) - offsetY : 0));
    const best = distances.indexOf(Math.min(...distances));
    return distances[best] <= (pointerType === 'touch' ? 2 * near : near) ? best : -1;
  }

  take(event, canvas, which) {
    let index = this.indexAt(event, canvas, which);
    if (index < 0) index = this.add(which, this.valueAt(event, canvas));
    this.select(which, index);
  }

  move(event, canvas) {
    const [value, opacity] = this.valueAt(event, canvas), { which, index } = this.selected;
    const rest = which === 'opacities' ? [opacity] : this.point.slice(1);
    this.app.transfer.edit(withPointAt(this.tf, which, index, [value, ...rest]));
  }

  /** A new point on the curve (or where the pointer is), its index. */
  add(which, [value, opacity]) {
    const point = which === 'opacities' ? [value, opacity] : [value, ...colourAt(this.tf, value)];
    const { tf, index } = withPoint(this.tf, which, point);
    this.app.transfer.edit(tf);
    return index;
  }

  remove(which = this.selected.which, index = this.selected.index) {
    if (!canLose(this.tf, which)) return;
    this.app.transfer.edit({ ...this.tf, name: 'edited', [which]: this.tf[which].toSpliced(index, 1) }, true);
    this.select(which, Math.max(0, index - 1));
  }

  keys(which) {
    const chosen = (act) => (event) => {
      if (this.selected.which !== which) this.select(which, 0);
      act(event);
    };
    const move = (values, opacities) => chosen(({ shiftKey }) => {
      const [low, high] = this.app.valueRange(), [value, ...rest] = this.point, fine = shiftKey ? 0.002 : 0.01;
      if (which === 'opacities') rest[0] += opacities * fine;
      const point = [value + values * fine * (high - low), ...rest];
      this.app.sender.pulse();
      this.app.transfer.edit(withPointAt(this.tf, which, this.selected.index, point), true);
    });
    return {
      ArrowLeft: move(-1, 0), ArrowRight: move(1, 0), ArrowUp: move(0, 1), ArrowDown: move(0, -1),
      PageUp: chosen(() => this.select(which, this.selected.index - 1)),
      PageDown: chosen(() => this.select(which, this.selected.index + 1)),
      Home: () => this.select(which, 0), End: () => this.select(which, Infinity),
      Delete: chosen(() => this.remove()), Insert: chosen(() => this.addAfter(which, this.selected.index)),
    };
  }

  /** Halfway to the next point. */
  addAfter(which, index) {
    const points = this.tf[which], at = Math.min(index, points.length - 2);
    const value = 0.5 * (points[at][0] + points[at + 1][0]);
    const added = this.add(which, [value, opacityAt(this.tf, value)]);
    this.app.commit();
    this.select(which, added);
  }

  draw() {
    if (!this.app.scene.state || byId('curve').clientWidth === 0) return;  // folded
    this.selected.index = Math.min(this.selected.index, this.tf[this.selected.which].length - 1);
    this.drawCurve();
    this.drawStrip();
  }

  /** Counts by bin; a bin too narrow to hold any of an integer type's values looks like the one before. */
  counts() {
    const { counts, low, high } = this.app.volume.histogram, step = (high - low) / counts.length;
    if (!/int/.test(this.app.volume.type) || !(step < 1)) return counts;
    const isEmpty = (i) => Math.ceil(low + i * step - 1e-9) >= low + (i + 1) * step - 1e-9;
    return counts.map((n, i) => (i > 0 && n === 0 && isEmpty(i) ? counts[i - 1] : n));
  }

  drawHistogram(context, width, height) {
    const counts = this.counts(), size = settings.logAxis ? (n) => Math.log1p(n) : (n) => n;
    const highest = Math.max(...counts.map(size), 1e-9), wide = (width - 2 * side) / counts.length;
    context.fillStyle = themeColour('--curve');
    context.beginPath();
    counts.forEach((n, i) => {
      const tall = (size(n) / highest) * (height - top - bottom);
      context.rect(side + i * wide, height - bottom - tall, wide + 0.3, tall);
    });
    context.fill();
  }

  drawCurve() {
    const { context, width, height } = fitCanvas(byId('curve'));
    this.drawHistogram(context, width, height);
    const accent = themeColour('--accent');
    const places = this.tf.opacities.map((p) => [this.x(p[0], width), this.y(p[1], height)]);
    trace(context, [[0, places[0][1]], ...places, [width, places.at(-1)[1]]]);
    context.lineWidth = 1.75;
    context.strokeStyle = accent;
    context.stroke();
    places.forEach((place, i) => {
      const chosen = this.selected.which === 'opacities' && this.selected.index === i;
      context.beginPath();
      context.arc(...place, chosen ? 6 : 4, 0, 2 * Math.PI);
      context.fillStyle = chosen ? accent : themeColour('--panel');
      context.fill();
      context.stroke();
    });
  }

  drawStrip() {
    const { context, width, height } = fitCanvas(byId('strip')), band = height - 12;
    context.fillStyle = addColours(context.createLinearGradient(side, 0, width - side, 0), this.tf, this.app.valueRange());
    context.fillRect(0, 0, width, band);
    this.tf.colours.forEach((stop, i) => {
      const x = this.x(stop[0], width), chosen = this.selected.which === 'colours' && this.selected.index === i;
      trace(context, [[x, band - 4], [x + 6, height - 1.5], [x - 6, height - 1.5]]);
      context.closePath();
      context.fillStyle = toHex(stop.slice(1));
      context.fill();
      context.lineWidth = chosen ? 2.5 : 1;
      context.strokeStyle = chosen ? themeColour('--accent') : themeColour('--text');
      context.stroke();
    });
  }
}
