// A simulation that is shown while it runs: how far it is, holding it, and the numbers that it offers.

import { byId, download, element, fileStem, onNumber, show } from './dom.js';
import { showError } from './status.js';
import { spread } from './transfer_function.js';
import { mostMembers, tar } from './tar.js';

const mostBytes = 2 ** 31;  // of recorded pictures, which are held in memory

export class RunPanel {
  constructor(app) {
    this.app = app;
    this.run = null;
    this.recorded = null;  // pictures of steps, while they are taken
    byId('run-pause').addEventListener('click', () => this.toggle());
    byId('run-step').addEventListener('click', () => this.steer('step'));
    // Spreads the transfer function over the values that there are now.
    byId('run-fit').addEventListener('click', () => {
      const { low, high } = app.volume.histogram, { transfer } = app;
      if (app.mayEdit() && high > low) transfer.edit(spread(transfer.tf, low, high), true);
    });
    byId('run-record').addEventListener('click', () => this.record());
  }

  begin() {
    this.stopRecording();
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
    if (known !== run.parameters.map(({ name }) => name).join()) {
      this.fields = new Map(run.parameters.map((one) => [one.name, this.makeField(one)]));
      byId('run-parameters').replaceChildren(...[...this.fields].map(([name, field]) => element('label', {}, name, field)));
    }
    for (const { name, value } of run.parameters) this.put(name, value);
    this.look?.();
  }

  /** Of a number, or of one of several choices. */
  makeField({ name, low, high, choices }) {
    const set = (value) => this.steer('set', { parameter: name, value });
    if (choices.length)
      return element('select', { onchange: ({ target }) => set(Number(target.value)) },
                     ...choices.map((words, value) => element('option', { value: String(value) }, words)));
    const field = element('input', { type: 'number', step: 'any', min: low, max: high, title: `${low} to ${high}` });
    onNumber(field, set, () => this.put(name, this.run.parameters.find((one) => one.name === name).value));
    return field;
  }
  put(name, value) {
    const field = this.fields.get(name);
    if (field !== document.activeElement || field.type !== 'number') field.value = show(value, 6);
  }

  /** Holds the simulation and lets it take one step after another: a picture of each, in a TAR, until it is stopped. */
  async record() {
    if (this.recorded) return void this.stopRecording();
    this.recorded = [];
    this.recording = true;
    this.steer('pause');
    const { app, recorded } = this, { width, height } = app.stage.canvas, stem = fileStem(app.volume.name);
    const say = (words) => { byId('run-record').textContent = words; };
    say('Stop (0)');
    let step = null, bytes = 0;
    try {
      while (await this.until((run) => run.paused && run.step !== step)) {
        const { blob } = await app.connection.ask({ type: 'snapshot', width, height, format: 'png', state: app.scene.state });
        step = this.run.step;  // is told before its picture comes
        recorded.push({ name: `${stem}-${String(step).padStart(6, '0')}.png`, bytes: new Uint8Array(await blob.arrayBuffer()) });
        say(`Stop (${recorded.length})`);
        bytes += blob.size;
        if (recorded.length === mostMembers || bytes > mostBytes) break;
        this.steer('step');
      }
    } catch (error) {
      showError(`Recording ended: ${error.message}`);
    }
    this.steer('resume');
    this.recorded = null;
    say('Record');
    if (recorded.length) download(`${stem}-steps.tar`, tar(recorded));
  }
  /** Whether what is told of the simulation became as `condition` wants, before recording was stopped. */
  until(condition) {
    return new Promise((resolve) => {
      this.look = () => (!this.recording || condition(this.run)) && resolve(this.recording);
      this.look();
    });
  }
  stopRecording() {
    this.recording = false;
    this.look?.();
  }
}
