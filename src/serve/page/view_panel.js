// Camera, light, shading and background by fields; the six views by buttons and by a cube that turns as the volume does.

import { basisOf, sixViews } from './camera.js';
import { byId, clamp, element, onColour, onDrag, onKeys, onNumber, show, toHex } from './dom.js';

const cameraFields = ['azimuth', 'elevation', 'roll', 'zoom'], panFields = ['pan-right', 'pan-down'];
const lightFields = ['light-right', 'light-up', 'light-front'];

/** For CSS, whose y axis points down: where a body's own axes come to lie. */
const turned = (x, y, z) => `matrix3d(${[...x, 0, ...y, 0, ...z, 0, 0, 0, 0, 1]})`;

export class ViewPanel {
  constructor(app) {
    this.app = app;
    const refresh = () => this.refresh();
    for (const id of cameraFields)
      onNumber(byId(id), (value) => app.scene.change({ camera: { [id]: value } }), refresh);
    panFields.forEach((id, k) => onNumber(byId(id), (value) =>
      app.scene.change({ camera: { pan: app.scene.state.camera.pan.with(k, value) } }), refresh));
    byId('reset').addEventListener('click', () => app.resetCamera());
    byId('finer').addEventListener('click', () => app.openPart(true));
    byId('whole').addEventListener('click', () => app.openPart(false));
    for (const radio of document.getElementsByName('projection'))
      radio.addEventListener('change', () => app.setProjection(radio.value === 'perspective'));
    onNumber(byId('fov'), (fov) =>
      app.scene.state.camera.fov > 0 && app.scene.change({ camera: { fov, distance: 0 } }), refresh);
    byId('shading').addEventListener('change', () => app.toggleShading());
    onColour(app, byId('background'), (background) => app.scene.change({ background }));
    lightFields.forEach((id, k) => onNumber(byId(id), (value) => {
      const light = app.scene.state.light.with(k, value);
      if (Math.hypot(...light) > 0) app.scene.change({ light });
    }, refresh));
    const pad = byId('light-pad');
    const take = ({ offsetX, offsetY }) =>
      this.aim((2 * offsetX) / pad.clientWidth - 1, 1 - (2 * offsetY) / pad.clientHeight);
    onDrag(app, pad, { begin: take, move: take });
    const move = (right, up) => () => {
      const [x, y] = this.unitLight();
      app.sender.pulse();
      this.aim(x + right, y + up);
    };
    onKeys(app, pad, { ArrowLeft: move(-0.1, 0), ArrowRight: move(0.1, 0), ArrowUp: move(0, 0.1),
                       ArrowDown: move(0, -0.1) });
  }

  begin({ volume: { patient }, finer, is_part: isPart }) {
    byId('finer').hidden = !finer;
    byId('whole').hidden = !isPart;
    const make = (tag, attributes) => sixViews.map((view, i) => element(tag,
      { ...attributes(view, i), onclick: () => this.app.lookFrom(view) }, patient ? view.patient : view.axis));
    byId('six-views').replaceChildren(...make('button', ({ name }, i) => {
      const title = `From the ${name.toLowerCase()} (${i + 1})`;
      return { title, 'aria-label': title };
    }));
    this.cube = element('div', {}, ...make('span', () => ({})));
    sixViews.forEach((view, i) => {
      const { right, up, viewer } = basisOf({ ...view, roll: 0 });
      this.cube.children[i].style.transform = `${turned(right, up.map((c) => -c), viewer)} translateZ(var(--half))`;
    });
    byId('cube').replaceChildren(this.cube);
  }

  /** The sides of the cube look where the volume's do. */
  turnCube(camera) {
    const { right, up, viewer } = basisOf(camera);
    this.cube.style.transform = turned(...[0, 1, 2].map((k) => [right[k], -up[k], viewer[k]]));
  }

  refresh() {
    const { state } = this.app.scene;
    if (!state) return;
    const { camera, light } = state;
    const put = (id, value) => (byId(id).value = Number(value.toFixed(3)));
    for (const id of cameraFields) put(id, camera[id]);
    panFields.forEach((id, k) => put(id, camera.pan[k]));
    lightFields.forEach((id, k) => put(id, light[k]));
    for (const radio of document.getElementsByName('projection'))
      radio.checked = (radio.value === 'perspective') === camera.fov > 0;
    if (camera.fov > 0) byId('fov').value = show(camera.fov);
    byId('fov').disabled = !(camera.fov > 0);
    byId('shading').checked = state.shading === 'phong';
    byId('background').value = toHex(state.background);
    const pad = byId('light-pad'), [x, y, z] = this.unitLight();
    pad.style.setProperty('--x', `${50 + 50 * x}%`);
    pad.style.setProperty('--y', `${50 - 50 * y}%`);
    pad.classList.toggle('behind', z < 0);
  }

  unitLight() {
    const { light } = this.app.scene.state, size = Math.hypot(...light);
    return light.map((c) => c / size);
  }

  /** A place on the ball, from its middle in radii, as the light's direction. */
  aim(x, y) {
    const away = Math.hypot(x, y), shrink = away > 1 ? 1 / away : 1;
    const [right, up] = [x * shrink, y * shrink];
    const front = Math.sqrt(clamp(1 - right * right - up * up, 0, 1));
    this.app.scene.change({ light: [right, up, front].map((c) => Number(c.toFixed(4))) });
  }
}
