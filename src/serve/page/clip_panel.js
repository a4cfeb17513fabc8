// The clip box: three double sliders with numbers, and handles at the middles of its faces on the picture.

import { byId, clamp, dualSlider, element, onDrag, onKeys } from './dom.js';
import { settings } from './settings.js';

const axes = ['x', 'y', 'z'], ends = ['from', 'to'];

export const wholeBox = (dims) => dims.map((n) => [0, n]);

export class ClipPanel {
  constructor(app) {
    this.app = app;
    this.sliders = axes.map((name, axis) => this.makeSlider(name, axis));
    this.handles = axes.flatMap((name, axis) => ends.map((end, k) => this.makeHandle(name, axis, end, k)));
    byId('clip-on').addEventListener('change', () => app.toggleClip());
    byId('clip-whole').addEventListener('click', () => app.scene.change({ clip: wholeBox(app.volume.dims) }));
  }

  makeSlider(name, axis) {
    const slider = dualSlider(this.app, ends.map((end) => `Clip ${name} ${end}`), 'voxels', 1,
                              (end, voxel) => this.put(axis, end, voxel));
    byId('clip-sliders').append(element('div', { class: 'axis', role: 'group', 'aria-label': `Clip along ${name}` },
                                        element('span', {}, name), ...slider.parts));
    return slider;
  }

  get clip() {
    return this.app.scene.state.clip ?? wholeBox(this.app.volume.dims);
  }

  /** Puts a face elsewhere; the box keeps a voxel at least and stays in the volume. */
  put(axis, end, voxel) {
    if (!Number.isFinite(voxel)) return void this.refresh();
    const range = [...this.clip[axis]], place = Math.round(voxel), most = this.app.volume.dims[axis];
    range[end] = end === 0 ? clamp(place, 0, range[1] - 1) : clamp(place, range[0] + 1, most);
    this.app.scene.change({ clip: this.clip.with(axis, range) });
  }

  makeHandle(name, axis, end, k) {
    const button = element('button', { 'aria-label': `Face of the clip box: ${name} ${end}; arrow keys move it`,
                                       title: `${name} ${end}` });
    let from;
    onDrag(this.app, button, {
      begin: ({ clientX, clientY }) => {
        from = { x: clientX, y: clientY, voxel: this.clip[axis][k], way: this.way(axis, k) };
      },
      move: ({ clientX, clientY }) => {
        const along = (clientX - from.x) * from.way[0] + (clientY - from.y) * from.way[1];
        this.put(axis, k, from.voxel + along);
      },
    });
    const shift = (by) => (event) => {
      this.app.sender.pulse();
      this.put(axis, k, this.clip[axis][k] + by * (event.shiftKey ? 10 : 1));
    };
    onKeys(this.app, button, { ArrowRight: shift(1), ArrowUp: shift(1), ArrowLeft: shift(-1), ArrowDown: shift(-1) });
    byId('clip-handles').append(button);
    return button;
  }

  middle(axis, end) {
    return this.clip.map((range, k) => (k === axis ? range[end] : 0.5 * (range[0] + range[1])) - 0.5);
  }

  /** Voxels that a face moves for each pixel right and down. A face that looks at the viewer follows up and down. */
  way(axis, end) {
    const { project } = this.app.seen(), at = this.middle(axis, end);
    const [a, b] = [project(at), project(at.with(axis, at[axis] + 1))];
    const [x, y] = [b[0] - a[0], b[1] - a[1]], square = x * x + y * y;
    const size = Math.max(1e-9, this.app.seen().pixelsPerUnit * this.app.volume.spacing[axis]);
    if (square > (0.15 * size) ** 2) return [x / square, y / square];
    return [0, -Math.sign(b[2] - a[2]) / size];
  }

  /** Puts the handles to their places on the picture. */
  place() {
    const { state } = this.app.scene, shown = state.clip !== null && settings.box && this.app.mayEdit();
    byId('clip-handles').hidden = !shown;
    if (!shown) return;
    const { project } = this.app.seen(), centre = project(this.clip.map(([a, b]) => 0.5 * (a + b - 1)))[2];
    this.handles.forEach((button, i) => {
      const [x, y, near] = project(this.middle(i >> 1, i & 1));
      button.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      button.classList.toggle('behind', near < centre - 1e-6);
    });
  }

  refresh() {
    const { state } = this.app.scene, { dims } = this.app.volume;
    byId('clip-on').checked = state.clip !== null;
    byId('clip-whole').disabled = state.clip === null;
    this.sliders.forEach((slider, axis) => slider.display(this.clip[axis], [0, dims[axis]], state.clip === null));
  }
}
