// A simulation that is shown while it runs: how far it is, holding it, and the numbers that it offers.

import { byId, element, onNumber, show } from './dom.js';
import { spread } from './transfer_function.js';

export class RunPanel {
  constructor(app) {
    this.app = app;
    this.run = null;
    byId('run-pause').addEventListener('click', () => this.toggle());
    byId('run-step').addEventListener('click', () => this.steer('step'));
    byId('run-fit').addEventListener('click', () => this.fit());
  }

  begin() {
    this.run = null;
    byId('run').hidden = true;
  }

  /** Pictures wait for steps, and the last word is never said. */
  get goesOn() {
    return this.run !== null && !this.run.paused;
  }

  steer(act, more = {}) {
    if (this.run && this.app.driving) this.app.connection.send({ type: 'steer', act, ...more });
  }
  toggle() {
    this.steer(this.run?.paused ? 'resume' : 'pause');
  }

  /** What the server says of the simulation. */
  told(run) {
    if (run.step !== this.run?.step) this.app.slices.ask();
    const known = this.run?.parameters.map(({ name }) => name).join();
    this.run = run;
    this.app.volume.histogram = run.histogram;
    this.app.transfer.refresh();
    this.app.refresh();
    byId('run').hidden = false;
    byId('run-words').textContent = [`step ${run.step}`, run.time !== 0 && `time ${show(run.time)}`,
      run.paused ? 'held' : `${show(run.rate, 2)} steps a second`].filter(Boolean).join(', ');
    byId('run-pause').textContent = run.paused ? 'Go on' : 'Hold';
    if (known !== run.parameters.map(({ name }) => name).join()) this.list(run.parameters);
    for (const { name, value } of run.parameters) this.put(name, value);
  }

  list(parameters) {
    this.fields = new Map(parameters.map(({ name, low, high }) =>
      [name, element('input', { type: 'number', step: 'any', min: low, max: high, title: `${low} to ${high}` })]));
    byId('run-parameters').replaceChildren(...[...this.fields].map(([name, field]) => {
      const back = () => this.put(name, this.run.parameters.find((one) => one.name === name).value);
      onNumber(field, (value) => this.steer('set', { parameter: name, value }), back);
      return element('label', {}, name, field);
    }));
  }
  put(name, value) {
    const field = this.fields.get(name);
    if (field !== document.activeElement) field.value = show(value, 6);
  }

  /** Spreads the transfer function over the values that there are now. */
  fit() {
    const { low, high } = this.app.volume.histogram, { transfer } = this.app;
    if (this.app.mayEdit() && high > low) transfer.edit(spread(transfer.tf, low, high), true);
  }
}
