// The value under the cursor: a cross on the picture, a note beside it, and words for screen readers. And a ruler: how
// far the last places that were asked for lie from each other.

import { dot, inWorld, length, sum } from './camera.js';
import { byId, clamp, show } from './dom.js';
import { showError } from './status.js';

export class Probe {
  constructor(app) {
    this.app = app;
    this.canvas = byId('picture');
    this.cross = null;  // CSS pixels of the canvas
    this.asked = 0;
  }

  /** The last three places, on the lattice. */
  get places() {
    return this.app.scene.state.ruler;
  }

  /** `second`: of the volume that is compared. */
  async ask(place, second = false) {
    [this.cross, this.second] = [place, second];
    this.app.redraw();
    const asked = ++this.asked, { stage } = this.app, { width, height, scale, left, top } = stage.fit();
    const pixel = place.map((p, k) => Math.floor((p * stage.pixelsEach - [left, top][k]) / scale));
    if (pixel[0] < 0 || pixel[1] < 0 || pixel[0] >= width || pixel[1] >= height) return;
    try {
      const answer = await this.app.connection.ask({ type: 'probe', x: pixel[0], y: pixel[1], compared: second });
      if (asked === this.asked) this.show(answer);
    } catch (error) {
      if (asked === this.asked) showError(`The value could not be asked for: ${error.message}`);
    }
  }

  show(answer) {
    if (answer.hit) this.app.slices.goTo(answer.voxel);
    if (answer.hit) this.mark(answer.voxel);
    const unit = this.app.volume.unit ? ' ' + this.app.volume.unit : '';
    const { channels } = this.app.scene.state, of = this.app.channels.all[channels.findIndex(({ visible }) => visible)];
    const { frame, compare } = this.app.compare.choice, { frames } = this.app.hello;
    const lines = answer.hit
      ? [`${of?.name ?? 'value'} ${show(answer.value, 6)}`, `voxel ${answer.voxel.map((v) => show(v, 5)).join(', ')}`,
         `world ${answer.world.map((v) => show(Number(v.toFixed(9)), 5)).join(', ')}${unit}`, ...this.measures()]
      : ['nothing opaque here'];
    if (compare !== null) lines.unshift(frames[this.second ? compare : frame]);
    byId('probe-words').textContent = lines.join('; ');
    byId('probe').textContent = lines.join('\n');
    byId('probe').hidden = false;
    const [x, y] = this.cross, { offsetWidth, offsetHeight } = byId('probe');
    const left = Math.min(x + 14, this.canvas.clientWidth - offsetWidth - 4);
    const below = y + 14 + offsetHeight < this.canvas.clientHeight;
    const { offsetLeft, offsetTop } = byId(this.second ? 'second' : 'picture');
    byId('probe').style.transform =
      `translate(${offsetLeft + left}px, ${offsetTop + (below ? y + 14 : y - 14 - offsetHeight)}px)`;
  }

  /** Another end of the ruler. */
  mark(voxel) {
    this.lay([...this.places.slice(-2), voxel]);
  }

  lay(ruler) {
    this.app.scene.measure(ruler);
    this.app.addressLater();
    this.app.redraw();
  }

  /** The ruler's places, and what is written at the middle of its lines. */
  lengths() {
    const { places, app: { volume } } = this, ways = this.ways();
    return { places, words: ways.map((way) => `${show(length(way), 5)} ${volume.unit || 'units'}`) };
  }
  ways() {
    const world = this.places.map((place) => inWorld(this.app.volume, place));
    return world.slice(1).map((to, k) => sum([1, to], [-1, world[k]]));
  }

  /** From the place before to the last one; and the angle at the middle of three. */
  measures() {
    const ways = this.ways(), words = this.lengths().words.slice(-1).map((far) => `${far} from the place before`);
    if (ways.length > 1) {
      const cosine = -dot(...ways) / (length(ways[0]) * length(ways[1]) || 1);
      words.push(`angle at that ${show((180 / Math.PI) * Math.acos(clamp(cosine, -1, 1)), 4)}°`);
    }
    return words;
  }

  hide() {
    if (!this.cross) return;
    ++this.asked;
    this.cross = null;
    byId('probe').hidden = true;
    byId('probe-words').textContent = '';
    this.app.redraw();
  }

  middle() {
    return [0.5 * this.canvas.clientWidth, 0.5 * this.canvas.clientHeight];
  }

  /** Moves the cross by some pixels and keeps it on the canvas. */
  move([right, down]) {
    const [x, y] = this.cross ?? this.middle(), { clientWidth, clientHeight } = this.canvas;
    byId('probe').hidden = true;
    this.second = false;  // only the first picture has lines over it
    this.cross = [clamp(x + right, 0, clientWidth - 1), clamp(y + down, 0, clientHeight - 1)];
    this.app.redraw();
  }
}
