// Another volume of the series from the same view: both side by side, or their difference.

import { byId, element, fileStem } from './dom.js';

/** |A − B| of each channel of two pictures, so many times, and the largest before that. */
export function differenceOf(bitmaps, gain) {
  const { width, height } = bitmaps[0];
  const [a, b] = bitmaps.map((bitmap) => {
    const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
    context.drawImage(bitmap, 0, 0);
    return { context, image: context.getImageData(0, 0, width, height) };
  });
  const to = a.image.data, from = b.image.data;
  let largest = 0;
  for (let i = 0; i < to.length; ++i) {
    if (i % 4 === 3) continue;  // opaque
    const error = Math.abs(to[i] - from[i]);
    if (error > largest) largest = error;
    to[i] = gain * error;
  }
  a.context.putImageData(a.image, 0, 0);
  return { canvas: a.context.canvas, gain, largest };
}

export class ComparePanel {
  constructor(app) {
    this.app = app;
    byId('compare').addEventListener('change', ({ target }) =>
      app.scene.change({ compare: target.value === '' ? null : Number(target.value) }));
    for (const id of ['side-by-side', 'difference', 'gain'])
      byId(id).addEventListener('change', () =>
        app.scene.change({ difference: id === 'side-by-side' ? 0 : Number(byId('gain').value) }));
  }

  begin() {
    byId('compare').replaceChildren(element('option', { value: '' }, 'nothing'),
                                    ...this.app.hello.frames.map((name, value) => element('option', { value }, name)));
  }

  get choice() {
    const { frame, compare, difference } = this.app.scene.state;
    return { frame, compare, gain: compare === null ? 0 : difference, beside: compare !== null && difference === 0 };
  }

  /** Side by side, the difference, neither. */
  toggle() {
    const { frames } = this.app.hello, { frame, compare, beside } = this.choice;
    if (frames.length < 2) return;
    if (compare === null) this.app.scene.change({ compare: frame + 1 < frames.length ? frame + 1 : frame - 1, difference: 0 });
    else this.app.scene.change(beside ? { difference: Number(byId('gain').value) } : { compare: null, difference: 0 });
  }

  /** Both pictures, and the difference of PNGs where it is shown, for a ZIP; `ask(part)` gets one of another scene. */
  async files(ask, format) {
    const { frame, compare, gain } = this.choice, pictures = [];
    for (const one of [frame, compare]) pictures.push([this.app.hello.frames[one], await ask({ frame: one })]);
    if (gain && format === 'png') {
      const bitmaps = pictures.map(([, blob]) => createImageBitmap(blob, { colorSpaceConversion: 'none' }));
      const { canvas } = differenceOf(await Promise.all(bitmaps), gain);
      pictures.push([`difference-x${gain}`, await canvas.convertToBlob()]);
    }
    const stems = pictures.map(([name]) => fileStem(name));
    return Promise.all(pictures.map(async ([, blob], k) => (
      { name: `${stems[k]}${stems.indexOf(stems[k]) === k ? '' : `-${k + 1}`}.${format}`, bytes: new Uint8Array(await blob.arrayBuffer()) })));
  }

  refresh() {
    const { compare, gain, beside } = this.choice;
    byId('compare').value = compare ?? '';
    byId('compare-as').hidden = compare === null;
    byId(gain ? 'difference' : 'side-by-side').checked = true;
    if (gain) byId('gain').value = gain;
    byId('gain').disabled = !gain;
    byId('stage').classList.toggle('compared', beside);
  }

  /** Names what the stage shows: of the picture that is there its own volumes, and the difference where it is drawn. */
  name(shown, difference) {
    const { choice, app: { hello: { frames } } } = this;
    const [first, second] = [shown?.frame ?? choice.frame, shown?.compare ?? choice.compare].map((k) => frames[k]);
    const found = shown?.exact ? `largest ${difference?.largest} of 255` : 'while it changes';
    byId('first-name').hidden = choice.compare === null;
    const caption = difference ? `|${first} − ${second}| × ${difference.gain}, ${found}` : first;
    for (const [id, text] of [['first-name', caption], ['second-name', second ?? '']])
      if (byId(id).textContent !== text) byId(id).textContent = text;
  }
}
