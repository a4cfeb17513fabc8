// The list of channels that are drawn together: which are seen, in what colours, over which values.

import { byId, dualSlider, element, onColour, toHex } from './dom.js';

export class ChannelsPanel {
  constructor(app) {
    this.app = app;
    this.all = [];  // what the server says of each
    byId('materials').addEventListener('change', ({ target }) => app.scene.change({ materials: target.checked }));
    byId('reset-channels').addEventListener('click', () => app.scene.change({ channels: app.hello.state.channels }));
  }

  begin(channels) {
    this.all = channels;
    this.windows = {};  // by mode, those that were left
    byId('transfer').classList.toggle('of-channels', channels.length > 0);
    if (channels.length) byId('transfer-title').textContent = 'Channels';
    this.rows = channels.map(({ name }, k) => this.makeRow(name, k));
    byId('channel-list').replaceChildren(...this.rows.map(({ row }) => row));
  }

  makeRow(name, k) {
    const seen = element('input', { type: 'checkbox',
                                    onchange: ({ target }) => this.change(k, { visible: target.checked }) });
    const colour = element('input', { type: 'color', 'aria-label': `Colour of ${name}` });
    onColour(this.app, colour, (chosen) => this.change(k, { colour: chosen }));
    const slider = dualSlider(this.app, [`${name} from`, `${name} to`], 'value', 'any', (end, value) => this.put(k, end, value));
    const row = element('li', {}, element('label', { class: 'tick', title: name }, seen, element('span', {}, name)),
                        colour, element('div', { class: 'window' }, ...slider.parts));
    return { row, seen, colour, slider };
  }

  get channels() {
    return this.app.scene.state.channels;
  }

  change(k, part) {
    this.app.scene.change({ channels: this.channels.with(k, { ...this.channels[k], ...part }) });
  }
  /** The names and colours of those that are seen. */
  legend() {
    return this.channels.map((channel, k) => ({ ...channel, ...this.all[k] })).filter(({ visible }) => visible);
  }
  /** Puts an end of a window elsewhere, but not past the other; a surface has one value. */
  put(k, end, value) {
    const ofSurface = this.app.scene.state.mode === 'surface';
    const window = ofSurface ? [value, value] : this.channels[k].window.with(end, value);
    if (window[0] < window[1] || (ofSurface && Number.isFinite(value))) this.change(k, { window });
    else this.refresh();
  }

  /** Each mode has windows of its own, which it gets back. */
  inMode(mode) {
    this.windows[this.app.scene.state.mode] = this.channels.map(({ window }) => window);
    return this.channels.map((channel, k) => ({ ...channel, window: this.windows[mode]?.[k] ?? this.all[k].windows[mode] }));
  }

  refresh() {
    const { mode, materials } = this.app.scene.state;
    byId('materials').checked = materials;
    byId('materials-label').hidden = mode !== 'composite' || this.all.length === 0;
    this.channels.forEach(({ visible, colour, window }, k) => {
      const row = this.rows[k], { range, windows } = this.all[k];
      row.seen.checked = visible;
      row.colour.value = toHex(colour);
      // Integrals over length are no values of voxels.
      const ends = [...window, ...windows[mode], ...(mode === 'sum' ? [2 * windows.sum[1]] : range)];
      row.slider.display(window, [Math.min(...ends), Math.max(...ends)]);
      row.slider.second.forEach((input) => (input.hidden = mode === 'surface'));
    });
  }
}
