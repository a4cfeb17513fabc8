// The transfer function's panel: fields of the selected point, presets, maps, window and level, undo, files.

import { CurveEditor } from './curve_editor.js';
import { byId, download, element, onColour, onNumber, show, toHex } from './dom.js';
import { onSettings } from './settings.js';
import { canLose, maps, stretched, toParaView, windowOf, withMap, withPointAt } from './transfer_function.js';

const mostBytes = 60000;  // of a map, nearly a whole message

export class TransferPanel {
  constructor(app) {
    this.app = app;
    this.editor = new CurveEditor(app, () => this.refresh());
    const put = (change, whole = true) => {
      const { which, index } = this.editor.selected;
      this.edit(withPointAt(this.tf, which, index, change(this.editor.point)), whole);
    };
    const refresh = () => this.refresh();
    onNumber(byId('point-value'), (value) => put((p) => p.with(0, value)), refresh);
    onNumber(byId('point-opacity'), (opacity) => put((p) => p.with(1, opacity)), refresh);
    onColour(app, byId('point-colour'), (colour) => put(([value]) => [value, ...colour], false));
    byId('point-colour').addEventListener('change', () => app.commit());
    byId('point-delete').addEventListener('click', () => this.editor.remove());
    onNumber(byId('level'),
             (level) => this.edit(stretched(this.tf, 1, level - windowOf(this.tf).level), true), refresh);
    onNumber(byId('window'), (width) => {
      const now = windowOf(this.tf).width;
      if (width > 0 && now > 0) this.edit(stretched(this.tf, width / now, 0), true);
    }, refresh);
    this.choose('maps', maps, (map) => withMap(this.tf, map));
    // Each mode has a function of its own, which it gets back.
    byId('mode').addEventListener('change', ({ target: { value: mode } }) => {
      this.functions[app.scene.state.mode] = this.tf;
      app.scene.change({ mode, transfer_function: this.functions[mode], channels: app.channels.inMode(mode) });
      app.commit();
    });
    onNumber(byId('isovalue'), (isovalue) => {
      app.scene.change({ isovalue });
      app.commit();
    }, refresh);
    byId('import-tf').addEventListener('click', () => app.openJson(async (map) => {
      if (JSON.stringify(map).length > mostBytes) throw new Error('it is larger than the server takes');
      const { transfer_function } = await app.connection.ask({ type: 'map', map });
      this.edit(transfer_function, true);
    }, 'Give a colour map as ParaView exports it.'));
    byId('export-tf').addEventListener('click', () =>
      download(`${this.tf.name}.json`, new Blob([toParaView(this.tf)], { type: 'application/json' })));
    onSettings(() => this.editor.draw());
  }

  get tf() {
    return this.app.scene.state.transfer_function;
  }

  begin({ presets, modes }) {
    this.presets = presets;
    this.functions = { ...modes };
    byId('modes').hidden = Object.keys(this.functions).length === 0;
    this.choose('presets', presets, (preset) => preset);
  }

  /** Has a list, behind its first entry, offer functions, or what becomes one. */
  choose(id, all, functionOf) {
    byId(id).replaceChildren(byId(id).options[0], ...all.map(({ name }) => element('option', { value: name }, name)));
    byId(id).onchange = ({ target }) => {
      const chosen = all.find(({ name }) => name === target.value);
      if (chosen) this.edit(functionOf(chosen), true);
    };
  }

  /** Shows an edit; `whole` ones are steps of undo by themselves. */
  edit(tf, whole = false) {
    if (this.app.channels.all.length) return;  // they have functions of their own
    this.app.scene.change({ transfer_function: tf });
    if (whole) this.app.commit();
  }

  refresh() {
    if (!this.app.scene.state) return;
    this.editor.draw();
    const { mode, isovalue } = this.app.scene.state;
    byId('mode').value = mode;
    byId('isovalue').value = show(isovalue, 6);
    byId('isovalue-label').hidden = mode !== 'surface' || this.app.channels.all.length > 0;
    const { which } = this.editor.selected, point = this.editor.point, opacity = which === 'opacities';
    byId('point-value').value = show(point[0], 6);
    byId('point-opacity-label').hidden = !opacity;
    byId('point-colour-label').hidden = opacity;
    if (opacity) byId('point-opacity').value = show(point[1]);
    else byId('point-colour').value = toHex(point.slice(1));
    byId('point-delete').disabled = !canLose(this.tf, which);
    const { level, width } = windowOf(this.tf);
    byId('level').value = show(level, 5);
    byId('window').value = show(width, 5);
    byId('maps').value = '';
    byId('presets').value = this.presets.some(({ name }) => name === this.tf.name) ? this.tf.name : '';
  }
}
