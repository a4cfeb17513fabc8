// What the page says: the status line, the banner of those who watch, errors, and the job's end.

import { byId, element, show } from './dom.js';

const errorStays = 15000;  // milliseconds

export function showLink(status) {
  const words = { connecting: 'connecting', open: 'connected', lost: 'connection lost, trying again', ended: 'ended',
                  refused: 'not connected', waiting: 'waiting for the ranks' };
  byId('link').dataset.status = status;
  byId('link').textContent = words[status];
}

/** Coarse data is shown until `part` of the volume, which is loaded, is 1. */
export function showLoading(part) {
  byId('loading').hidden = part === 1;
  byId('loading-words').textContent = 'Coarse data, an eighth of the voxels, while the volume is loaded';
  byId('loading-part').value = part;
}
/** Another part of the volume, which is said by the next greeting. */
export function showOpening() {
  showLoading(0);
  byId('loading-words').textContent = 'The part is read; the page comes back to it';
}
export function showsCoarse() {
  return !byId('loading').hidden;
}

/** `picture`: facts of the one on the canvas; `latency` in milliseconds of the view's first picture. */
export function showFacts(picture, latency, hello) {
  const { ranks, layout, levels } = hello;
  const quality = picture.atRest ? 'full quality' : showsCoarse() ? 'coarse data' : 'coarser while it changes';
  byId('facts').textContent = [Number.isFinite(latency) && `${latency.toFixed(0)} ms`, quality].filter(Boolean).join(', ');
  const more = [
    picture.rate > 0 && !picture.atRest && `${picture.rate.toFixed(picture.rate < 10 ? 1 : 0)} pictures a second`,
    `${picture.width} × ${picture.height}`,
    Number.isFinite(picture.error) && !picture.atRest && `error ${show(picture.error, 2)} of 255`,
    `${ranks} ${ranks === 1 ? 'rank' : 'ranks'}`,
  ];
  byId('more-facts').textContent = more.filter(Boolean).join(' · ');
  byId('status').title = `${levels[picture.level]} (${picture.level + 1} of ${picture.levels}); ${layout}`;
}

export function showDriver(driving, viewers) {
  byId('banner').hidden = driving;
  const others = viewers > 2 ? `, ${viewers} in all` : '';
  byId('banner-text').textContent = `You are watching${others}; another page drives.`;
  byId('controls').disabled = !driving;
}

/** The same message is shown once, however often it comes. `stays`: until it is dismissed. */
export function showError(message, hint, stays = false) {
  const box = byId('messages');
  const same = [...box.children].find((child) => child.dataset.text === message);
  same?.remove();
  const note = element('div', { 'data-text': message },
    element('div', {}, element('p', {}, message), ...(hint ? [element('p', { class: 'hint' }, hint)] : [])),
    element('button', { 'aria-label': 'Dismiss', onclick: () => note.remove() }, '✕'));
  box.append(note);
  while (box.children.length > 3) box.firstChild.remove();
  if (!stays) setTimeout(() => note.remove(), errorStays);
  return note;
}

export function showEnd(message, tryAgain) {
  const dialog = byId('ended');
  byId('ended-words').textContent = message || 'The server said no more.';
  byId('loading-words').textContent = 'Coarse data: the volume was not loaded';
  byId('try-again').onclick = tryAgain;
  if (!dialog.open) dialog.showModal();
}

export function showVolume({ name, dims, spacing, unit, type }) {
  document.title = `${name} – Ringsplat`;
  byId('volume-name').textContent = name;
  byId('volume-facts').textContent = byId('volume-facts').title =
    `${dims.join(' × ')} ${type}, ${spacing.map((s) => show(s, 2)).join(' × ')}${unit ? ' ' + unit : ''}`;
}
