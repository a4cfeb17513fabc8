// Another volume of the series from the same view: both side by side, or their difference.

import { byId, element, fileStem } from './dom.js';

/** |A − B| of each channel of two pictures, so many times, and the largest before that. */
export function differenceOf([a, b], gain) {
  const canvas = new OffscreenCanvas(a.width, a.height);
  const context = canvas.getContext('2d', { alpha: false, willReadFrequently: true });
  context.drawImage(a, 0, 0);
  context.globalCompositeOperation = 'difference';
  context.drawImage(b, 0, 0);
  const { data } = context.getImageData(0, 0, a.width, a.height);
  const largest = data.reduce((most, value, k) => (k % 4 < 3 && value > most ? value : most), 0);
  context.globalCompositeOperation = 'lighter';
  for (let times = 1; times < gain; times *= 2) context.drawImage(canvas, 0, 0);
  return { canvas, gain, largest };
}

export class ComparePanel {
  constructor(app) {
    this.app = app;
    byId('compare').addEventListener('change', ({ target }) =>
      app.scene.change({ compare: target.value === '' ? null : Number(target.value) }));
    byId('difference').addEventListener('change', ({ target }) => app.scene.change({ difference: Number(target.value) }));
    this.gain = 1;
  }

  begin() {
    byId('compare').replaceChildren(element('option', { value: '' }, 'nothing'),
                                    ...this.app.hello.frames.map((name, value) => element('option', { value }, name)));
  }

  get choice() {
    const { frame, difference, ...state } = this.app.scene.state;
    const compare = state.compare === frame ? null : state.compare;  // a volume is not compared with itself
    return { frame, compare, gain: compare === null ? 0 : difference, beside: compare !== null && difference === 0 };
  }

  /** Side by side, the difference, neither. */
  toggle() {
    const { frames } = this.app.hello, { frame, compare, beside } = this.choice;
    if (frames.length < 2) return;
    if (compare === null) this.app.scene.change({ compare: frame + 1 < frames.length ? frame + 1 : frame - 1, difference: 0 });
    else this.app.scene.change(beside ? { difference: this.gain } : { compare: null, difference: 0 });
  }

  /** Both pictures, and the difference of PNGs where it is shown, for a TAR; `ask(part)` gets one of another scene. */
  async files(ask, format) {
    const { frame, compare, gain } = this.choice, files = [];
    const add = async (name, blob) => files.push({ name: `${name}.${format}`, bytes: new Uint8Array(await blob.arrayBuffer()) });
    const blobs = [await ask({ frame }), await ask({ frame: compare })];
    for (const [k, volume] of [frame, compare].entries()) await add(`${k + 1}-${fileStem(this.app.hello.frames[volume])}`, blobs[k]);
    if (!gain || format !== 'png') return files;
    const bitmaps = await Promise.all(blobs.map((blob) => createImageBitmap(blob, { colorSpaceConversion: 'none' })));
    await add(`difference-x${gain}`, await differenceOf(bitmaps, gain).canvas.convertToBlob());
    return files;
  }

  refresh() {
    const { frame, compare, gain, beside } = this.choice, { app } = this;
    // Of two volumes each takes the other's place.
    if (app.driving && app.scene.state.compare === frame && app.hello.frames.length === 2) return void app.adjust({ compare: 1 - frame });
    for (const option of byId('compare').options) option.disabled = option.value === String(frame);
    byId('compare').value = compare ?? '';
    byId('difference').hidden = compare === null;
    byId('difference').value = gain;
    this.gain = gain || this.gain;
    byId('stage').classList.toggle('compared', beside);
  }

  /** Names what the stage shows: of the picture that is there its own volumes, and the difference where it is drawn. */
  name(shown, difference) {
    const { choice, app: { hello: { frames } } } = this;
    const [first, second] = [shown?.frame ?? choice.frame, shown?.compare ?? choice.compare].map((k) => frames[k]);
    const found = shown?.exact ? `largest ${difference?.largest} of 255` : 'while it changes';
    byId('first-name').hidden = choice.compare === null;
    byId('first-name').textContent = difference ? `|${first} − ${second}| × ${difference.gain}, ${found}` : first;
    byId('second-name').textContent = second ?? '';
  }
}
