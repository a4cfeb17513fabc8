// Starts the page, and tells tests what it shows.

import { App } from './app.js';
import { letters } from './cube.js';

const app = new App();

window.ringsplat = Object.freeze({
  get state() { return structuredClone(app.scene.state); },
  get hello() { return structuredClone(app.hello); },
  get shown() { return structuredClone(app.stage.list); },
  get connection() { return app.connection.status; },
  get driving() { return app.driving; },
  get seq() { return app.sender.seq; },
  /** The present view's final picture is on the canvas. */
  get settled() {
    const last = app.stage.list.at(-1);
    return app.connection.status === 'open' && !app.sender.moving && !app.sender.request.waits && !app.stage.draw.waits &&
           last !== undefined && last.atRest && (!app.driving || last.seq === app.sender.seq);
  },
  get letters() { return letters(app.scene.state.camera, app.volume.patient); },
  get scale() { return structuredClone(app.scale); },
  get probe() { return structuredClone(app.probing.result); },
  get slices() { return { at: app.slices.at, words: app.slices.words, drawn: app.slices.drawn }; },
  get frame() { return app.series.seen; },
  get playing() { return app.series.playing; },
  get keyFrames() { return app.film.frames.length; },
});
