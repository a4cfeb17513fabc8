// The page as a whole: what messages and controls do to the scene, the picture and each other.

import { fillingZoom, viewOf } from './camera.js';
import { ClipPanel, wholeBox } from './clip_panel.js';
import { ClipPlanesPanel } from './clip_planes_panel.js';
import { Connection, kinds } from './connection.js';
import { ChannelsPanel } from './channels_panel.js';
import { ComparePanel } from './compare_panel.js';
import { byId, onceAFrame, openFile } from './dom.js';
import { FilmPanel } from './film_panel.js';
import { FramePanel } from './frame_panel.js';
import { Gestures } from './gestures.js';
import { History } from './history.js';
import { attachKeyboard } from './keyboard.js';
import { drawOverlay } from './overlay.js';
import { LabelsPanel } from './labels_panel.js';
import { Probe } from './probe.js';
import { RunPanel } from './run_panel.js';
import { Scene, checkedState, readFragment } from './scene.js';
import { Sender } from './sender.js';
import { attachSettings, onSettings, settings } from './settings.js';
import { SnapshotPanel } from './snapshot_panel.js';
import { ErrorsPanel } from './errors_panel.js';
import { Stage } from './stage.js';
import { Slices } from './slices.js';
import { showDriver, showEnd, showError, showFacts, showLink, showLoading, showOpening, showVolume, showsCoarse } from './status.js';
import { TransferPanel } from './transfer_panel.js';
import { ViewPanel } from './view_panel.js';

const lossesTold = 3;
const waitTold = 1000;      // milliseconds without a picture
const fragmentWait = 300;  // milliseconds; browsers limit how often the address may change

class App {
  constructor() {
    this.scene = new Scene((keys) => this.sceneChanged(keys));
    this.history = new History();
    this.hello = null;
    this.driving = true;
    this.latency = NaN;
    this.latencyOf = -1;
    this.losses = 0;
    this.changed = new Set();  // members of the scene, since the last redraw
    this.refresh = onceAFrame(() => this.refreshNow());
    this.stage = new Stage(this);
    this.sender = new Sender((view) => this.sendView(view));
    this.connection = new Connection(() => this.token, {
      message: (message) => this.take(message), binary: (head) => this.takeBinary(head),
      status: (status) => this.linkChanged(status) });
    this.transfer = new TransferPanel(this);
    this.labels = new LabelsPanel(this);
    this.channels = new ChannelsPanel(this);
    this.viewPanel = new ViewPanel(this);
    this.clipPanel = new ClipPanel(this);
    this.clipPlanes = new ClipPlanesPanel(this);
    this.film = new FilmPanel(this);
    this.series = new FramePanel(this);
    this.compare = new ComparePanel(this);
    this.runs = new RunPanel(this);
    this.snapshots = new SnapshotPanel(this);
    this.errors = new ErrorsPanel(this);
    this.probing = new Probe(this);
    this.slices = new Slices(this);
    this.gestures = ['picture', 'second'].map((id) => new Gestures(this, byId(id)));
    attachKeyboard(this);
    attachSettings();
    onSettings(() => byId('stage').classList.toggle('with-slices', settings.slices));
    byId('undo').addEventListener('click', () => this.undo(false));
    byId('redo').addEventListener('click', () => this.undo(true));
    byId('take-over').addEventListener('click', () => this.connection.send({ type: 'drive' }));
    window.addEventListener('hashchange', () => this.readAddress() && this.connection.reopen());
    window.addEventListener('beforeunload', (event) => (this.film.job || this.runs.recorded) && event.preventDefault());
    // A page that the browser keeps for "back" must not go on driving.
    window.addEventListener('pagehide', () => this.connection.close());
    window.addEventListener('pageshow', (event) => event.persisted && this.connection.reopen());
    onSettings(() => this.refreshPanels());
    this.readAddress();
    this.connection.open();
  }

  /** Takes token and scene from the address. True when a new token came. */
  readAddress() {
    const { token, state } = readFragment(location.hash), key = 'ringsplat.token ' + location.pathname;
    if (token) sessionStorage.setItem(key, token);
    this.token = token ?? sessionStorage.getItem(key) ?? '';
    if (state === undefined) showError('The address holds a scene that cannot be read.');
    if (state) {
      const checked = checkedState(state);
      if (checked.refused.length) showError(`The address holds an unfit ${checked.refused.join(', ')}.`);
      if (this.scene.state) this.takeState(checked.state);
      else this.brought = checked.state;
    }
    const rest = state ? location.hash.replace(/^#[^&]*&?/, '#') : '';
    if (token) history.replaceState(history.state, '', location.pathname + location.search + rest);
    return token !== null;
  }

  // What the server says.

  take(message) {
    const acts = {
      hello: () => this.greet(message),
      driver: () => this.setDriver(message.you, message.viewers),
      state: () => this.follow(message.state),
      frame: () => this.series.told(message),
      run: () => this.runs.told(message),
      loading: () => showLoading(message.part),
      opening: () => showOpening(),
      errors: () => { this.errors.told = message; },
      error: () => this.connection.fail(message.id, message.message) || showError(message.message, message.hint),
      warning: () => showError(message.message, message.hint, true),
      end: () => this.ended(message.message),
    };
    if (Object.hasOwn(acts, message.type)) acts[message.type]();
    else this.connection.answer(message.id, message);
  }

  greet(hello) {
    this.hello = hello;
    const { volume } = hello, resumes = this.scene.state !== null && this.driving && hello.part === this.part;
    this.part = hello.part;
    this.fills = hello.state.camera.zoom === 1;  // nobody chose another
    showVolume(volume);
    showLoading(1);
    this.stage.forget();
    this.stage.largest = hello.largest;
    this.stage.resize();
    this.viewPanel.begin(hello);
    const kept = resumes ? this.scene.state : hello.driver ? this.brought : {};
    this.brought = undefined;
    this.fill();
    this.scene.begin(hello.state, this.fitting(kept));
    if (!resumes) this.history.clear(this.scene.state);
    this.series.begin();
    this.compare.begin();
    this.runs.begin();
    this.transfer.begin(hello);
    this.labels.begin(volume.labels, hello.segments, hello.state.tints);
    this.channels.begin(hello.channels);
    this.film.begin(hello.ffmpeg, resumes);
    this.snapshots.begin(hello.largest);
    this.errors.begin(hello.errors);
    this.setDriver(hello.driver, hello.viewers);
    this.slices.begin(resumes);
    this.refreshPanels();
  }

  setDriver(driving, viewers) {
    if (driving !== this.driving) this.stage.forget();
    [this.driving, this.scene.locked] = [driving, !driving];
    showDriver(driving, viewers);
    this.redraw();
    if (driving) return void this.sender.request();
    this.film.stop();
    this.series.stop();
    this.runs.stopRecording();
  }

  /** The driver's scene, for those who watch. */
  follow(state) {
    if (this.driving || !this.hello) return;
    this.scene.begin(this.hello.state, { ...state, ruler: this.scene.state.ruler });
    this.history.clear(this.scene.state);
    this.showUndo();
  }

  async takeBinary(head) {
    if (head.kind !== kinds.picture) return void this.connection.answer(head.number, head);
    await this.stage.take(head);
    this.connection.send({ type: 'ack', picture: head.number });
  }

  /** `latency`: milliseconds since its view was sent. */
  pictureShown(picture, latency) {
    if (picture.seq !== this.latencyOf && this.driving) [this.latency, this.latencyOf] = [latency, picture.seq];
    if (!this.driving || this.stage.sent.get(picture.seq)?.frame === this.series.frame) this.series.pictureShown();
    showFacts(picture, this.driving ? this.latency : NaN, this.hello);
    this.awaitPicture(false);
    const final = (picture.atRest || showsCoarse()) && picture.seq === this.sender.seq;
    this.awaitPicture(this.driving && !this.runs.goesOn && !final);
    if (!this.driving) this.redraw();
  }

  linkChanged(status) {
    this.awaitPicture(false);
    showLink(status);
    if (status === 'refused')
      this.refusal = showError(this.token ? 'The token of this address is not the server\'s.' : 'This address lacks its token.',
                    'Open the whole address that ringsplat serve printed when it started.', true);
    if (status !== 'open') this.connection.failAll('the connection was lost');
    if (status === 'open') this.losses = 0;
    if (status === 'open') this.refusal?.remove();
    if (status === 'lost' && ++this.losses === lossesTold && !showsCoarse())
      showError('The server does not answer.', 'If it was started anew, open the address that it printed then.');
  }

  /** Says so when the present view's final picture lets one wait. */
  awaitPicture(waits) {
    if (waits && this.waiting) return;
    if (this.waiting) showLink(this.connection.status);
    clearTimeout(this.waiting);
    this.waiting = waits ? setTimeout(() => showLink('waiting'), waitTold) : 0;
  }

  ended(message) {
    this.connection.failAll('the job has ended');
    this.runs.stopRecording();
    showEnd(message, () => this.connection.reopen());
  }

  // What changes the scene.

  sceneChanged(keys) {
    if (this.driving) this.sender.request();
    this.probing.hide();
    this.errors.hide();
    for (const key of keys) this.changed.add(key);
    this.redraw();
    this.addressLater();
  }

  addressLater() {
    clearTimeout(this.fragmentTimer);
    this.fragmentTimer = setTimeout(() => this.writeFragment(), fragmentWait);
  }

  mayEdit() {
    return this.driving && this.scene.state !== null;
  }

  takeState(given) {
    this.scene.change(this.fitting(given));
  }
  /** A scene may come from a longer series, or a volume with other channels or labels. */
  fitting(state) {
    const { channels, compare, frame, tints, ...rest } = state ?? {}, last = this.hello.frames.length - 1;
    if (channels?.length === this.hello.channels.length) rest.channels = channels;
    const labels = this.hello.segments;
    if (tints?.length === labels.length && labels.every(({ value }, k) => tints[k][0] === value)) rest.tints = tints;
    if (frame !== undefined) rest.frame = Math.min(frame, last);
    if (compare !== undefined) rest.compare = compare === null || last === 0 ? null : Math.min(compare, last);
    return rest;
  }

  /** A step of undo ends here. */
  commit() {
    if (this.mayEdit()) this.history.commit(this.scene.state);
    this.showUndo();
  }
  /** Changes what nobody asked for, which is no step. */
  adjust(part) {
    this.scene.change(part);
    this.history.replace(part);
  }
  undo(again) {
    if (!this.mayEdit()) return;
    this.commit();
    this.film.stop();
    const state = this.history.step(again);
    if (state) this.scene.change(state);
    this.showUndo();
  }
  showUndo() {
    byId('undo').disabled = this.history.past.length === 0;
    byId('redo').disabled = this.history.future.length === 0;
  }

  valueRange() {
    const { low, high } = this.volume.histogram;
    return high > low ? [low, high] : [low, low + 1];
  }
  valueSpan() {
    const [low, high] = this.valueRange();
    return high - low;
  }

  resetCamera() {
    this.film.stop();
    this.scene.change({ camera: this.hello.state.camera });
  }
  lookFrom({ azimuth, elevation }) {
    this.film.stop();
    this.scene.change({ camera: { azimuth, elevation, roll: 0 } });
  }
  setProjection(perspective) {
    this.scene.change({ camera: { fov: perspective ? byId('fov').valueAsNumber : 0, distance: 0 } });
  }
  toggleShading() {
    this.scene.change({ shading: this.scene.state.shading === 'phong' ? 'none' : 'phong' });
  }
  toggleClip() {
    if (this.scene.state.clip) this.lastClip = this.scene.state.clip;
    this.scene.change({ clip: this.scene.state.clip ? null : this.lastClip ?? wholeBox(this.volume.dims) });
  }

  probe(place, second) {
    if (this.scene.state) this.probing.ask(place, second);
  }
  quiet() {
    this.film.stop();
    this.series.stop();
    this.probing.hide();
    this.probing.lay([]);
  }

  // What shows it.

  get volume() {
    return this.hello.volume;
  }

  sendView({ seq, moving }) {
    if (!this.mayEdit()) return false;
    if (!moving) this.commit();
    const { width, height } = this.stage.canvas;
    const { state } = this.scene, time = performance.now();
    const sent = this.connection.send({ type: 'view', seq, moving, width, height, time, state });
    if (sent) this.stage.remember(seq, this.scene.state);
    if (sent) this.awaitPicture(!this.runs.goesOn);
    return sent;
  }

  /** Has the server show only what is seen, as finely as that can be held, or the whole volume again. */
  openPart(seen) {
    const { width, height } = this.stage.canvas;
    this.connection.send({ type: 'part', seen, width, height, state: this.scene.state });
  }

  /** How the volume lies on the stage, in CSS pixels. */
  seen() {
    const { width, height, scale, left, top } = this.stage.fit(), each = this.stage.pixelsEach;
    const view = viewOf(this.scene.state.camera, this.volume, width, height);
    const project = (p) => {
      const [x, y, near] = view.project(p);
      return [(x * scale + left) / each, (y * scale + top) / each, near];
    };
    return { ...view, project, pixelsPerUnit: (view.pixelsPerUnit * scale) / each };
  }

  /** Lets the first view fill the page, and a view that nobody has zoomed. */
  fill() {
    if (!this.fills) return;
    const { camera } = this.hello.state, { width, height } = this.stage.canvas;
    const untouched = this.scene.state?.camera.zoom === camera.zoom;
    camera.zoom = Number(fillingZoom(camera, this.volume, width, height).toPrecision(4));
    if (!untouched || !this.mayEdit()) return;
    this.adjust({ camera: { zoom: camera.zoom } });
  }

  resized() {
    this.errors.hide();
    if (this.hello) this.fill();
    if (this.driving) this.sender.pulse();
    this.sender.request();
    this.redraw();
  }

  redraw() {
    this.stage.draw();
    this.refresh();
  }

  refreshNow() {
    const keys = this.changed;
    this.changed = new Set();
    if (!this.scene.state) return;
    if (keys.has('transfer_function') || keys.has('isovalue')) this.transfer.refresh();
    if (keys.has('transfer_function') || keys.has('tints')) this.labels.refresh();
    if (keys.has('channels') || keys.has('materials')) this.channels.refresh();
    if (keys.size > 1 || !keys.has('transfer_function')) this.viewPanel.refresh();
    if (keys.has('clip')) this.clipPanel.refresh();
    if (keys.has('clip_planes')) this.clipPlanes.refresh();
    if (keys.has('frame')) this.series.refresh();
    if (['frame', 'compare', 'difference'].some((key) => keys.has(key))) this.compare.refresh();
    this.slices.refresh();
    const { state } = this.scene, { cross, second } = this.probing;
    this.scale = drawOverlay({ state, volume: this.volume, seen: this.seen(), cross: second ? null : cross,
                                ruler: this.probing.lengths(), slices: this.slices.boxes(),
                                legend: [...this.channels.legend(), ...this.labels.legend],
                                differs: this.compare.choice.gain > 0, errors: this.errors.shown });
    byId('cube').hidden = !settings.cube;
    if (settings.cube) this.viewPanel.turnCube(state.camera);
    this.clipPanel.place();
  }

  refreshPanels() {
    if (!this.scene.state) return;
    this.changed = new Set(Object.keys(this.scene.state));
    this.redraw();
  }

  writeFragment() {
    if (!this.scene.state) return;
    const fragment = this.scene.fragment();
    history.replaceState(history.state, '', location.pathname + location.search + (fragment ? '#' + fragment : ''));
  }

  /** Has `use` take what is in a JSON file; says so, with a hint, when that fails. */
  async openJson(use, hint) {
    const file = await openFile('.json');
    if (!file) return;
    try {
      await use(JSON.parse(await file.text()));
    } catch (error) {
      showError(`${file.name} cannot be used: ${error.message}`, hint);
    }
  }
}

window.app = new App();  // for tests
