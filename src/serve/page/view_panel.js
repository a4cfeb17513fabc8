// Camera, light, shading and background by fields.

import { sixViews } from './camera.js';
import { byId, clamp, element, fromHex, onDrag, onKeys, onNumber, show, toHex } from './dom.js';

const cameraFields = ['azimuth', 'elevation', 'roll', 'zoom'], panFields = ['pan-right', 'pan-down'];
const lightFields = ['light-right', 'light-up', 'light-front'];

export class ViewPanel {
  constructor(app) {
    this.app = app;
    const refresh = () => this.refresh();
    for (const id of cameraFields)
      onNumber(byId(id), (value) => app.scene.change({ camera: { [id]: value } }), refresh);
    panFields.forEach((id, k) => onNumber(byId(id), (value) =>
      app.scene.change({ camera: { pan: app.scene.state.camera.pan.with(k, value) } }), refresh));
    byId('reset').addEventListener('click', () => app.resetCamera());
    for (const radio of document.getElementsByName('projection'))
      radio.addEventListener('change', () => app.setProjection(radio.value === 'perspective'));
    onNumber(byId('fov'), (fov) =>
      app.scene.state.camera.fov > 0 && app.scene.change({ camera: { fov, distance: 0 } }), refresh);
    byId('shading').addEventListener('change', () => app.toggleShading());
    byId('background').addEventListener('input', ({ target }) => {
      app.sender.pulse();
      app.scene.change({ background: fromHex(target.value) });
    });
    lightFields.forEach((id, k) => onNumber(byId(id), (value) => {
      const light = app.scene.state.light.with(k, value);
      if (Math.hypot(...light) > 0) app.scene.change({ light });
    }, refresh));
    this.attachPad();
  }

  begin(patient) {
    byId('six-views').replaceChildren(...sixViews.map((view, i) => {
      const title = `From the ${view.name.toLowerCase()} (${i + 1})`;
      return element('button', { title, 'aria-label': title, onclick: () => this.app.lookFrom(view) },
                     patient ? view.patient : view.axis);
    }));
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
    this.showLight();
  }

  attachPad() {
    const pad = byId('light-pad');
    const take = ({ offsetX, offsetY }) =>
      this.aim((2 * offsetX) / pad.clientWidth - 1, 1 - (2 * offsetY) / pad.clientHeight);
    onDrag(this.app, pad, { begin: take, move: take });
    const move = (right, up) => () => {
      const [x, y] = this.unitLight();
      this.app.sender.pulse();
      this.aim(x + right, y + up);
    };
    onKeys(this.app, pad, { ArrowLeft: move(-0.1, 0), ArrowRight: move(0.1, 0), ArrowUp: move(0, 0.1),
                            ArrowDown: move(0, -0.1) });
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

  showLight() {
    const pad = byId('light-pad'), [x, y, z] = this.unitLight();
    pad.style.setProperty('--x', `${50 + 50 * x}%`);
    pad.style.setProperty('--y', `${50 - 50 * y}%`);
    pad.classList.toggle('behind', z < 0);
  }
}
