// Key frames: the list, playing them, and rendering a film at full quality.

import { byId, download, element, fileStem } from './dom.js';
import { checkedState } from './scene.js';
import { sceneAt } from './spline.js';
import { showError } from './status.js';
import { mostMembers, tar } from './tar.js';

export class FilmPanel {
  constructor(app) {
    this.app = app;
    this.frames = [];
    this.player = 0;
    this.job = null;  // of a film that is being rendered
    byId('add-key').addEventListener('click', () => this.add());
    byId('play').addEventListener('click', () => this.play());
    byId('clear-keys').addEventListener('click', () => this.set([]));
    byId('render-film').addEventListener('click', () => (this.job ? this.job.abort() : this.render()));
    this.set([]);
  }

  /** Key frames from outside. */
  take(list) {
    const { hello } = this.app, whole = (part) =>
      ({ ...hello.state, ...this.app.fitting(part), camera: { ...hello.state.camera, ...part.camera } });
    this.set(list.map((frame) => whole(checkedState(frame).state)));
  }

  set(frames) {
    this.stop();
    this.frames = frames = frames.map(({ ruler, ...frame }) => frame);  // pictures have the present one
    if (this.app.hello) history.replaceState({ film: this.app.volume.name, frames }, '');
    const act = (label, title, disabled, onclick) =>
      element('button', { 'aria-label': title, title, disabled, onclick }, label);
    byId('key-frames').replaceChildren(...frames.map((frame, i) => {
      const { azimuth, elevation, zoom } = frame.camera, name = `key frame ${i + 1}`;
      return element('li', {}, element('b', {}, String(i + 1)),
        element('span', {}, `${azimuth.toFixed(0)}°, ${elevation.toFixed(0)}°, ×${zoom.toFixed(2)}`),
        act('Go', `Show ${name}`, false, () => this.app.scene.change(frame)),
        act('Set', `Put the present view into ${name}`, false, () => this.set(frames.with(i, this.app.scene.state))),
        act('↑', `Move ${name} up`, i === 0, () => this.set(frames.toSpliced(i - 1, 2, frame, frames[i - 1]))),
        act('✕', `Delete ${name}`, false, () => this.set(frames.toSpliced(i, 1))));
    }));
    byId('clear-keys').disabled = frames.length === 0;
    this.enable();
  }
  /** What needs two key frames; a film can be cancelled whatever became of its own. */
  enable() {
    byId('play').disabled = this.frames.length < 2;
    byId('render-film').disabled = this.frames.length < 2 && !this.job;
  }

  add() {
    if (this.app.scene.state) this.set([...this.frames, this.app.scene.state]);
  }

  get secondsEach() {
    return Math.max(0.1, byId('film-seconds').valueAsNumber || 2);
  }
  get rate() {
    return Math.max(1, byId('film-rate').valueAsNumber || 25);
  }

  play() {
    if (this.player) return void this.stop();
    if (this.frames.length < 2 || !this.app.mayEdit()) return;
    this.app.series.stop();
    const begin = performance.now(), end = this.frames.length - 1;
    this.app.sender.hold();
    byId('play').setAttribute('aria-pressed', 'true');
    const step = () => {
      const time = (performance.now() - begin) / 1000 / this.secondsEach;
      this.app.scene.change(sceneAt(this.frames, Math.min(time, end), this.app.volume.dims));
      if (time >= end) this.stop();
      else this.player = requestAnimationFrame(step);
    };
    this.player = requestAnimationFrame(step);
  }

  stop() {
    if (!this.player) return;
    cancelAnimationFrame(this.player);
    this.player = 0;
    byId('play').setAttribute('aria-pressed', 'false');
    this.app.sender.release();
  }

  begin(ffmpeg, resumes) {
    byId('film-mp4').disabled = !ffmpeg;
    byId('film-format').value = ffmpeg ? 'mp4' : 'tar';
    // A reload keeps key frames, a new visit in the same tab does not.
    if (!resumes && history.state?.film === this.app.volume.name) this.take(history.state.frames);
  }

  async render() {
    const width = byId('film-width').valueAsNumber, height = byId('film-height').valueAsNumber;
    const count = Math.round((this.frames.length - 1) * this.secondsEach * this.rate) + 1;
    if (!(width > 0 && height > 0) || count > mostMembers)
      return void showError('The film cannot be rendered.', `Give a size, and at most ${mostMembers} frames.`);
    this.stop();
    this.job = new AbortController();
    byId('render-film').textContent = 'Cancel';
    Object.assign(byId('film-progress'), { hidden: false, max: count, value: 0 });
    const stem = fileStem(this.app.volume.name);
    try {
      if (byId('film-format').value === 'mp4') download(`${stem}.mp4`, await this.movie(width, height, count));
      else download(`${stem}-frames.tar`, tar(await this.pictures(width, height, count, stem)));
      byId('film-words').textContent = `${count} frames rendered`;
    } catch (error) {
      byId('film-words').textContent = this.job.signal.aborted ? 'cancelled' : '';
      if (!this.job.signal.aborted) showError(`The film was not rendered: ${error.message}`);
    }
    this.job = null;
    this.enable();
    byId('render-film').textContent = 'Render';
    byId('film-progress').hidden = true;
  }

  /** What the server answers to a question for each frame, whatever becomes of the key frames meanwhile. */
  async *answers(count, question) {
    const { frames } = this, { ruler } = this.app.scene.state;
    for (let index = 0; index < count; ++index) {
      byId('film-progress').value = index;
      byId('film-words').textContent = `${index} of ${count}`;
      const state = sceneAt(frames, (index / (count - 1)) * (frames.length - 1), this.app.volume.dims);
      yield await this.app.connection.ask({ ...question, index, state, ruler }, this.job.signal);
    }
  }

  async pictures(width, height, count, stem) {
    const members = [], digits = Math.max(4, String(count).length);
    for await (const { blob } of this.answers(count, { type: 'snapshot', width, height, format: 'png' }))
      members.push({ name: `${stem}-${String(members.length).padStart(digits, '0')}.png`,
                     bytes: new Uint8Array(await blob.arrayBuffer()) });
    return members;
  }

  /** The server keeps the frames and answers the last one with the film. */
  async movie(width, height, count) {
    const id = this.app.connection.nextId++, question = { type: 'movie_frame', id, count, fps: this.rate, width, height };
    try {
      for await (const { blob } of this.answers(count, question)) if (blob) return blob;
      throw new Error('the server sent no film');
    } catch (error) {
      this.app.connection.send({ type: 'cancel', id });
      throw error;
    }
  }
}
