// Camera, light, shading and background by fields.

import { sixViews } from './camera.js';
import { byId, clamp, element, fitCanvas, fromHex, onDrag, onNumber, show, themeColour, toHex } from './dom.js';
import { onSettings } from './settings.js';

const fields = {
  azimuth: (c, v) => ({ ...c, azimuth: v }), elevation: (c, v) => ({ ...c, elevation: v }),
  roll: (c, v) => ({ ...c, roll: v }), zoom: (c, v) => ({ ...c, zoom: v }),
  'pan-right': (c, v) => ({ ...c, pan: [v, c.pan[1]] }), 'pan-down': (c, v) => ({ ...c, pan: [c.pan[0], v] }),
};
const lightFields = ['light-right', 'light-up', 'light-front'];

export class ViewPanel {
  constructor(app) {
    this.app = app;
    const refresh = () => this.refresh();
    for (const [id, put] of Object.entries(fields))
      onNumber(byId(id), (value) => app.scene.change({ camera: put(app.scene.state.camera, value) }), refresh);
    byId('reset').addEventListener('click', () => app.resetCamera());
    for (const radio of document.getElementsByName('projection'))
      radio.addEventListener('change', () => app.setProjection(radio.value === 'perspective'));
    onNumber(byId('fov'), (degrees) => {
      app.lastFov = degrees;
      if (app.scene.state.camera.fov > 0) app.setProjection(true);
    }, refresh);
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
    onSettings(() => this.drawPad());
    new ResizeObserver(() => this.drawPad()).observe(byId('light-pad'));
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
    const values = { azimuth: camera.azimuth, elevation: camera.elevation, roll: camera.roll, zoom: camera.zoom,
                     'pan-right': camera.pan[0], 'pan-down': camera.pan[1] };
    for (const [id, value] of Object.entries(values)) byId(id).value = Number(value.toFixed(3));
    for (const radio of document.getElementsByName('projection'))
      radio.checked = (radio.value === 'perspective') === camera.fov > 0;
    byId('fov').value = show(camera.fov > 0 ? camera.fov : this.app.lastFov);
    byId('fov').disabled = !(camera.fov > 0);
    byId('shading').checked = state.shading === 'phong';
    byId('background').value = toHex(state.background);
    lightFields.forEach((id, k) => (byId(id).value = Number(light[k].toFixed(3))));
    this.drawPad();
  }

  attachPad() {
    const pad = byId('light-pad');
    const take = (event) => {
      const box = pad.getBoundingClientRect(), half = 0.5 * box.width - 4;
      this.aim((event.clientX - box.left - box.width / 2) / half, -(event.clientY - box.top - box.height / 2) / half);
    };
    onDrag(this.app, pad, { begin: take, move: take });
    pad.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
      if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      event.stopPropagation();
      const [x, y] = this.unitLight();
      this.app.sender.pulse();
      this.aim(x + step[0], y + step[1]);
    });
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

  drawPad() {
    if (!this.app.scene.state || byId('light-pad').clientWidth === 0) return;  // folded
    const { context, width, height } = fitCanvas(byId('light-pad')), radius = width / 2 - 4;
    const [x, y, z] = this.unitLight(), at = [width / 2 + x * radius, height / 2 - y * radius];
    const behind = z < 0;
    const ball = behind ? themeColour('--curve')
                        : context.createRadialGradient(...at, radius * 0.05, width / 2, height / 2, radius * 1.15);
    if (!behind) {
      ball.addColorStop(0, '#f4f1ea');
      ball.addColorStop(0.35, '#a9adb5');
      ball.addColorStop(1, '#3b3f47');
    }
    context.beginPath();
    context.arc(width / 2, height / 2, radius, 0, 2 * Math.PI);
    context.fillStyle = ball;
    context.fill();
    context.strokeStyle = themeColour('--line');
    context.stroke();
    context.beginPath();
    context.arc(...at, 5, 0, 2 * Math.PI);
    context.lineWidth = 2;
    context.strokeStyle = themeColour('--accent');
    if (!behind) {
      context.fillStyle = '#fff';
      context.fill();
    }
    context.stroke();
  }
}
