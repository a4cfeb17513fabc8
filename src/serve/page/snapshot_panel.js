// Pictures of any size and the scene, as files.

import { byId, download, fileStem } from './dom.js';
import { checkedState } from './scene.js';
import { showError } from './status.js';
import { tar } from './tar.js';

export class SnapshotPanel {
  constructor(app) {
    this.app = app;
    byId('snapshot').addEventListener('click', () => this.save());
    byId('snapshot-window').addEventListener('click', () => this.takeWindowSize());
    byId('save-state').addEventListener('click', () =>
      download(`${fileStem(app.volume.name)}-scene.json`,
               new Blob([app.scene.toFile(app.film.frames)], { type: 'application/json' })));
    byId('load-state').addEventListener('click', () => app.openJson((given) => {
      const { state, refused } = checkedState(given);
      if (refused.length) throw new Error(`it has an unfit ${refused.join(', ')}`);
      app.takeState(state);
      if (Array.isArray(given.key_frames)) app.film.take(given.key_frames);
    }, 'Give a scene that this page saved.'));
    byId('copy-link').addEventListener('click', () => this.copyLink());
  }

  takeWindowSize() {
    const { width, height } = this.app.stage.canvas;
    [byId('snapshot-width').value, byId('snapshot-height').value] = [width, height];
  }

  begin(largest) {
    for (const what of ['snapshot', 'film']) byId(`${what}-width`).max = byId(`${what}-height`).max = largest;
    if (!byId('snapshot-width').value) this.takeWindowSize();
  }

  async save() {
    const width = byId('snapshot-width').valueAsNumber, height = byId('snapshot-height').valueAsNumber;
    const valid = ['snapshot-width', 'snapshot-height'].every((id) => byId(id).checkValidity());
    if (!valid || !(width > 0 && height > 0))
      return void showError('A picture cannot have this size.',
                               `At most ${this.app.hello.largest} pixels a side.`);
    const format = byId('snapshot-format').value, button = byId('snapshot');
    button.disabled = true;
    byId('snapshot-words').textContent = 'rendering …';
    try {
      const { state } = this.app.scene, stem = `${fileStem(this.app.volume.name)}-${width}x${height}`;
      const ask = async (part) => (await this.app.connection.ask(
        { type: 'snapshot', width, height, format, ruler: state.ruler, state: { ...state, ...part } })).blob;
      if (this.app.compare.choice.compare === null) download(`${stem}.${format}`, await ask({}));
      else download(`${stem}-compared.tar`, tar(await this.app.compare.files(ask, format)));
      byId('snapshot-words').textContent = 'saved';
    } catch (error) {
      byId('snapshot-words').textContent = '';
      showError(`The picture was not saved: ${error.message}`);
    }
    button.disabled = false;
  }

  /** The address has the scene, but not the token. */
  async copyLink() {
    const button = byId('copy-link');
    try {
      this.app.writeFragment();
      await navigator.clipboard.writeText(location.href);
      button.textContent = 'Copied';
    } catch {
      showError('The link could not be copied.', 'Copy it from the address bar.');
    }
    setTimeout(() => (button.textContent = 'Copy link'), 1500);
  }
}
