// What the picture surely errs at most: a map over it, which goes when the picture changes.

import { byId } from './dom.js';
import { showError } from './status.js';

const pixels = 4096;  // of the map, which is a picture of the view by itself: so many are proved in seconds

export class ErrorsPanel {
  constructor(app) {
    this.app = app;
    this.shown = null;  // {bitmap, colours}, while the map is shown
    this.told = null;  // the words and colours that come before a map
    this.asks = 0;
    byId('errors').addEventListener('click', () => this.toggle());
  }

  begin(known) {
    byId('errors').disabled = !known;
    this.hide();
  }

  hide() {
    ++this.asks;
    if (this.shown) this.app.refresh();
    this.shown = null;
    byId('errors').setAttribute('aria-pressed', 'false');
    byId('errors-words').textContent = '';
  }

  async toggle() {
    if (this.shown) return void this.hide();
    if (this.app.compare.choice.compare !== null) return void showError('Errors are proved of one volume.', 'Show it alone.');
    const { app } = this, { width, height } = app.stage.canvas, scale = Math.min(1, Math.sqrt(pixels / (width * height)));
    const [across, down] = [width, height].map((side) => Math.max(1, Math.round(side * scale)));
    this.hide();
    const ask = this.asks;
    byId('errors-words').textContent = 'proving …';
    try {
      const { blob } = await app.connection.ask({ type: 'errors', width: across, height: down, state: app.scene.state });
      if (ask !== this.asks) return;
      this.shown = { bitmap: await createImageBitmap(blob), colours: this.told.colours };
      byId('errors-words').textContent = this.told.words;
      byId('errors').setAttribute('aria-pressed', 'true');
      app.refresh();
    } catch (error) {
      if (ask !== this.asks) return;
      this.hide();
      showError(`The errors are not known: ${error.message}`);
    }
  }
}
