// The list of a volume's labels, in place of the transfer function's curve, or of a segmentation's beside it: which
// are seen, in what colour.

import { byId, element, fromHex, toHex } from './dom.js';
import { colourAt, opacityAt } from './transfer_function.js';

/** Labels' opacities and colours up to half-way to the next whole numbers; all else is transparent. */
const labelFunction = (labels) => ({
  name: 'labels',
  colours: labels.flatMap(({ value, colour }) => [[value - 0.5, ...colour], [value + 0.5, ...colour]]),
  opacities: labels.flatMap(({ value: v, opacity }) =>
    [[v - 0.5, 0], [v - 0.5, opacity], [v + 0.5, opacity], [v + 0.5, 0]]),
});

export class LabelsPanel {
  constructor(app) {
    this.app = app;
    this.rows = [];
    byId('all-labels').addEventListener('click', () => this.change(() => ({ opacity: this.seenOpacity })));
    byId('no-labels').addEventListener('click', () => this.change(() => ({ opacity: 0 })));
  }

  begin(ofVolume, ofSegmentation, tints) {
    this.tinted = ofSegmentation.length > 0;
    this.seenOpacity = this.tinted ? tints[0][4] : 0.9;
    const labels = this.tinted ? ofSegmentation : ofVolume;
    byId('transfer').classList.toggle('of-labels', ofVolume.length > 0);
    byId('transfer').classList.toggle('tinted', this.tinted);
    byId('transfer-title').textContent = ofVolume.length ? 'Labels' : 'Transfer function';
    this.rows = labels.map(({ value, name }) => this.makeRow(value, name || `label ${value}`));
    byId('label-list').replaceChildren(...this.rows.map(({ row }) => row));
  }

  makeRow(value, name) {
    const change = (part) => this.change((label) => (label.value === value ? part : {}));
    const seen = element('input', { type: 'checkbox',
                                    onchange: ({ target }) => change({ opacity: target.checked ? this.seenOpacity : 0 }) });
    const colour = element('input', { type: 'color', 'aria-label': `Colour of ${name}`,
                                      onchange: ({ target }) => change({ colour: fromHex(target.value) }) });
    const number = name === `label ${value}` ? [] : [element('small', {}, String(value))];
    return { value, name, seen, colour, row: element('li', {}, element('label', { class: 'tick' }, seen, name), ...number, colour) };
  }

  labels() {
    const { transfer_function: tf, tints } = this.app.scene.state;
    if (this.tinted) return tints.map(([value, ...colour]) => ({ value, opacity: colour.pop(), colour }));
    return this.rows.map(({ value }) => ({ value, colour: colourAt(tf, value), opacity: opacityAt(tf, value) }));
  }

  /** The names and colours of those that are seen; asked for at each redraw, so kept until refresh(). */
  legend() {
    return (this.kept ??= this.labels().map((label, k) => ({ ...label, name: this.rows[k].name })).filter(({ opacity }) => opacity > 0));
  }

  /** `change(label)` gives the members of a label that become others. */
  change(change) {
    const labels = this.labels().map((label) => ({ ...label, ...change(label) }));
    if (this.tinted) this.app.scene.change({ tints: labels.map(({ value, colour, opacity }) => [value, ...colour, opacity]) });
    else this.app.transfer.edit(labelFunction(labels), true);
  }

  refresh() {
    this.kept = null;
    this.labels().forEach(({ opacity, colour }, k) => {
      this.rows[k].seen.checked = opacity > 0;
      this.rows[k].colour.value = toHex(colour);
    });
  }
}
