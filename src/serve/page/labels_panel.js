// The list of a volume's labels, in place of the transfer function's curve: which are seen, in what colour.

import { byId, element, fromHex, toHex } from './dom.js';
import { colourAt, opacityAt } from './transfer_function.js';

const seenOpacity = 0.9;

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
    byId('all-labels').addEventListener('click', () => this.change(() => ({ opacity: seenOpacity })));
    byId('no-labels').addEventListener('click', () => this.change(() => ({ opacity: 0 })));
  }

  begin(labels) {
    byId('transfer').classList.toggle('of-labels', labels.length > 0);
    byId('transfer-title').textContent = labels.length ? 'Labels' : 'Transfer function';
    this.rows = labels.map(({ value, name }) => this.makeRow(value, name || `label ${value}`));
    byId('label-list').replaceChildren(...this.rows.map(({ row }) => row));
  }

  makeRow(value, name) {
    const change = (part) => this.change((label) => (label.value === value ? part : {}));
    const seen = element('input', { type: 'checkbox',
                                    onchange: ({ target }) => change({ opacity: target.checked ? seenOpacity : 0 }) });
    const colour = element('input', { type: 'color', 'aria-label': `Colour of ${name}`,
                                      onchange: ({ target }) => change({ colour: fromHex(target.value) }) });
    const number = name === `label ${value}` ? [] : [element('small', {}, String(value))];
    return { value, seen, colour, row: element('li', {}, element('label', { class: 'tick' }, seen, name), ...number, colour) };
  }

  /** `change(label)` gives the members of a label that become others. */
  change(change) {
    const tf = this.app.scene.state.transfer_function;
    const labels = this.rows.map(({ value }) =>
      ({ value, colour: colourAt(tf, value), opacity: opacityAt(tf, value) }));
    this.app.transfer.edit(labelFunction(labels.map((label) => ({ ...label, ...change(label) }))), true);
  }

  refresh() {
    const tf = this.app.scene.state.transfer_function;
    for (const { value, seen, colour } of this.rows) {
      seen.checked = opacityAt(tf, value) > 0;
      colour.value = toHex(colourAt(tf, value));
    }
  }
}
