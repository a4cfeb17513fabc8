// The orientation cube: drawn from the camera; a click on a side looks at it.

import { basisOf, dot, sixViews } from './camera.js';
import { byId, clamp, fitCanvas, themeColour } from './dom.js';

/** A side's outward normal is the direction to the viewer in its own view. */
const sides = sixViews.map((view) => {
  const { right, up, viewer } = basisOf({ ...view, roll: 0 });
  const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) =>
    viewer.map((v, k) => v + x * right[k] + y * up[k]));
  return { view, normal: viewer, corners };
});

/** Where the six letters are for a camera: right and up of the cube's middle and towards the viewer, -1 to 1. */
export function letters(camera, patient) {
  const basis = basisOf(camera);
  return Object.fromEntries(sides.map(({ view, normal }) => [
    patient ? view.patient : view.axis,
    [dot(normal, basis.right), dot(normal, basis.up), dot(normal, basis.viewer)]]));
}

export class Cube {
  constructor(lookFrom) {
    this.canvas = byId('cube');
    this.canvas.addEventListener('click', (event) => {
      const box = this.canvas.getBoundingClientRect();
      const side = this.sideAt(event.clientX - box.left, event.clientY - box.top);
      if (side) lookFrom(side.view);
    });
  }

  draw(camera, patient) {
    const { context, width, height } = fitCanvas(this.canvas), size = Math.min(width, height) / 3.6;
    const basis = basisOf(camera);
    const place = (p) => [width / 2 + size * dot(p, basis.right), height / 2 - size * dot(p, basis.up)];
    const [fill, line, text] = ['--panel', '--dim', '--text'].map(themeColour);
    context.font = `600 ${Math.round(size * 0.62)}px system-ui, sans-serif`;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    this.drawn = [];
    for (const side of sides) {
      const facing = dot(side.normal, basis.viewer);
      if (facing < 1e-3) continue;
      const path = new Path2D();
      side.corners.map(place).forEach(([x, y], i) => (i ? path.lineTo(x, y) : path.moveTo(x, y)));
      path.closePath();
      context.globalAlpha = 0.86;
      context.fillStyle = fill;
      context.fill(path);
      context.globalAlpha = 1;
      context.strokeStyle = line;
      context.stroke(path);
      context.globalAlpha = clamp(3 * facing - 0.4, 0, 1);
      context.fillStyle = text;
      context.fillText(patient ? side.view.patient : side.view.axis, ...place(side.normal));
      context.globalAlpha = 1;
      this.drawn.push({ view: side.view, path });
    }
  }

  sideAt(x, y) {
    const context = this.canvas.getContext('2d');
    context.save();
    context.resetTransform();
    const found = this.drawn?.find(({ path }) => context.isPointInPath(path, x, y));
    context.restore();
    return found;
  }
}
