// The orientation cube, which turns as the volume does; a click on a side looks at it.

import { basisOf, sixViews } from './camera.js';
import { byId, element } from './dom.js';

/** For CSS, whose y axis points down: where a body's own axes come to lie. */
const turned = (x, y, z) => `matrix3d(${[...x, 0, ...y, 0, ...z, 0, 0, 0, 0, 1]})`;

export class Cube {
  constructor(lookFrom) {
    this.body = element('div');
    this.body.append(...sixViews.map((view) => {
      const side = element('span', { onclick: () => lookFrom(view) });
      const { right, up, viewer } = basisOf({ ...view, roll: 0 });
      side.style.transform = `${turned(right, up.map((c) => -c), viewer)} translateZ(var(--half))`;
      return side;
    }));
    byId('cube').append(this.body);
  }

  begin(patient) {
    sixViews.forEach((view, i) => (this.body.children[i].textContent = patient ? view.patient : view.axis));
  }

  draw(camera) {
    const { right, up, viewer } = basisOf(camera);
    this.body.style.transform = turned(...[0, 1, 2].map((k) => [right[k], -up[k], viewer[k]]));
  }
}
