// The keyboard: all that the mouse can do, and the list of it.

import { movePicture, sixViews, turning } from './camera.js';
import { byId, element } from './dom.js';
import { set, settings } from './settings.js';
import { windowed } from './transfer_function.js';

const step = (5 * Math.PI) / 180, panStep = 0.05, zoomStep = 1.1, rollStep = 5, crossStep = 8;

const gestures = [
  ['Drag', 'turn the volume (one finger, too)'],
  ['Shift + drag, middle button', 'pan (two fingers, too)'],
  ['Alt + drag', 'roll the picture (two fingers, too)'],
  ['Wheel, pinch', 'zoom to the cursor'],
  ['Right button', 'window (right) and level (up) of the transfer function'],
  ['Double click', 'value under the cursor'],
];

const arrows = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] };

/** What the single keys do: key, what the help says, and the action. */
function actions(app) {
  const camera = (change) => {
    app.sender.pulse();
    app.scene.change({ camera: change(app.scene.state.camera) });
  };
  const transfer = (factor, shift) => {
    app.sender.pulse();
    app.transfer.edit(windowed(app.scene.state.transfer_function, factor, shift * 0.02 * app.valueSpan()), true);
  };
  const toggle = (name) => () => set({ [name]: !settings[name] });
  return [
    ['+', 'zoom in', () => camera((c) => movePicture(c, { zoom: zoomStep })), '='],
    ['-', 'zoom out', () => camera((c) => movePicture(c, { zoom: 1 / zoomStep }))],
    [',', 'roll to the left', () => camera((c) => movePicture(c, { roll: -rollStep }))],
    ['.', 'roll to the right', () => camera((c) => movePicture(c, { roll: rollStep }))],
    ['r', 'reset the camera', () => app.resetCamera()],
    ...sixViews.map((view, i) => [String(i + 1), `from the ${view.name.toLowerCase()}`, () => app.lookFrom(view)]),
    ['p', 'orthographic or perspective', () => app.setProjection(app.scene.state.camera.fov === 0)],
    ['t', 'trackball or turntable',
     () => set({ turning: settings.turning === 'trackball' ? 'turntable' : 'trackball' })],
    ['w', 'narrower window', () => transfer(1 / 1.05, 0)],
    ['e', 'wider window', () => transfer(1.05, 0)],
    ['d', 'lower level', () => transfer(1, -1)],
    ['f', 'higher level', () => transfer(1, 1)],
    ['s', 'shading on or off', () => app.toggleShading()],
    ['c', 'clip box on or off', () => app.toggleClip()],
    ['o', 'orientation cube on or off', toggle('cube')],
    ['b', 'scale bar on or off', toggle('scale')],
    ['g', 'colour bar or legend on or off', toggle('colours')],
    ['x', 'handles of the clip box on or off', toggle('box')],
    ['q', 'slices beside the volume on or off', toggle('slices')],
    ['[', 'the frame before, of a series', () => app.series.step(-1)],
    [']', 'the next frame', () => app.series.step(1)],
    ['a', 'another volume of the series beside it, the difference, or neither', () => app.compare.toggle()],
    ['l', 'play the series', () => app.series.toggle()],
    ['m', 'hold the simulation, or let it go on', () => app.runs.toggle()],
    ['n', 'one step of the simulation', () => app.runs.steer('step')],
    ['k', 'add a key frame', () => app.film.add()],
    [' ', 'play the film', () => app.film.play()],
    ['v', 'save a picture', () => app.snapshots.save()],
    ['Enter', 'value at the cross or the cursor', () => {
      const second = document.activeElement.id === 'second', { cursor } = app.gestures[Number(second)];
      app.probe(app.probing.cross ?? cursor ?? app.probing.middle(), second);
    }],
    ['Escape', 'hide value and ruler, stop film and series', () => app.quiet()],
    ['\\', 'hide or show the controls',
     () => set({ folded: !document.body.classList.contains('folded') })],
    ['?', 'this list', () => byId('help').showModal()],
  ];
}

function fillHelp(list) {
  const keys = (...names) =>
    element('th', { scope: 'row' }, ...names.flatMap((name) => [element('kbd', {}, name), ' ']));
  const row = (head, text) => element('tr', {}, head, element('td', {}, text));
  const names = { ' ': 'Space', Escape: 'Esc' };
  const rows = list.map(([key, text]) => row(keys(names[key] ?? key), text)), half = 17;
  byId('help-gestures').append(
    ...gestures.map(([name, text]) => row(element('th', { scope: 'row' }, name), text)),
    row(keys('←', '→', '↑', '↓'), 'turn'), row(keys('Shift', 'arrows'), 'pan'),
    row(keys('Ctrl', 'arrows'), 'move a cross to ask for values'),
    row(keys('Ctrl', 'Z'), 'undo a change of the scene; with Shift: redo'));
  byId('help-views').append(...rows.slice(0, half));
  byId('help-keys').append(...rows.slice(half));
}

/** Keys belong to a field while it has the focus; a slider or button keeps only those that it uses. */
function isTaken(target, key) {
  if (target.closest('dialog')) return true;
  if (target.matches('select, textarea, input:not([type="checkbox"], [type="range"])')) return true;
  const moves = key in arrows || ['Home', 'End', 'PageUp', 'PageDown'].includes(key);
  const presses = key === ' ' || key === 'Enter';
  if (target.matches('input[type="range"], #curve, #strip, #light-pad, #clip-handles button'))
    return moves || presses || key === 'Insert' || key === 'Delete';
  return presses && target.matches('button, summary, input, a');
}

export function attachKeyboard(app) {
  const list = actions(app);
  fillHelp(list);
  byId('show-help').addEventListener('click', () => byId('help').showModal());
  const byKey = new Map(list.flatMap(([key, , act, also]) => [[key, act], ...(also ? [[also, act]] : [])]));
  window.addEventListener('keydown', (event) => {
    if (!app.scene.state || event.altKey || isTaken(event.target, event.key)) return;
    const controlled = event.ctrlKey || event.metaKey;
    const direction = arrows[event.key];
    if (direction && controlled) app.probing.move(direction.map((d) => d * crossStep));
    else if (direction) {
      const { camera } = app.scene.state, [right, down] = direction;
      app.film.stop();
      app.sender.pulse();
      app.scene.change({ camera: event.shiftKey ? movePicture(camera, { shift: [right * panStep, down * panStep] })
                                                : turning[settings.turning](camera, right * step, down * step) });
    } else if (controlled && event.key.toLowerCase() === 'z') app.undo(event.shiftKey);
    else if (!controlled && byKey.has(event.key)) byKey.get(event.key)();
    else return;
    event.preventDefault();
  });
}
