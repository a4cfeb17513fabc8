// The clip planes: each is put across a view and moved along it; what lies behind it, as seen from there, is left.

import { basisOf, boundingRadius } from './camera.js';
import { byId, element, show } from './dom.js';
import { mostPlanes } from './scene.js';

export class ClipPlanesPanel {
  constructor(app) {
    this.app = app;
    this.rows = Array.from({ length: mostPlanes }, (_, k) => this.makeRow(k));
    byId('clip-planes').append(...this.rows.map(({ row }) => row));
    byId('add-plane').addEventListener('click', () => app.mayEdit() && this.change([...this.planes, [...this.away(), 0]]));
  }

  makeRow(k) {
    const { app } = this, distance = element('output');
    const move = element('input', { type: 'range', step: 'any', 'aria-label': `Plane ${k + 1}, its distance`,
                                    oninput: ({ target }) => {
                                      app.sender.pulse();
                                      this.put(k, [...this.planes[k].slice(0, 3), target.valueAsNumber]);
                                    } });
    const turn = element('button', { title: 'Put it across this view',
                                     onclick: () => this.put(k, [...this.away(), this.planes[k][3]]) }, 'Turn');
    const remove = element('button', { 'aria-label': `Remove plane ${k + 1}`, title: `Remove plane ${k + 1}`,
                                       onclick: () => this.change(this.planes.toSpliced(k, 1)) }, '✕');
    return { move, distance, row: element('li', { class: 'row', hidden: true }, move, distance, turn, remove) };
  }

  get planes() {
    return this.app.scene.state.clip_planes;
  }
  change(planes) {
    this.app.scene.change({ clip_planes: planes });
  }
  put(k, plane) {
    this.change(this.planes.with(k, plane));
  }

  /** The world direction from the viewer. */
  away() {
    return basisOf(this.app.scene.state.camera).viewer.map((x) => -x);
  }

  refresh() {
    const radius = boundingRadius(this.app.volume);
    this.rows.forEach(({ row, move, distance }, k) => {
      row.hidden = k >= this.planes.length;
      if (row.hidden) return;
      Object.assign(move, { min: -radius, max: radius, value: this.planes[k][3] });
      distance.textContent = show(this.planes[k][3], 3);
    });
    byId('add-plane').disabled = this.planes.length >= mostPlanes;
  }
}
