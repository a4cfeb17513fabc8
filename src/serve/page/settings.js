// What a person chose for the page itself, kept by the browser: overlays, the way of dragging, the theme.

import { byId } from './dom.js';

const key = 'ringsplat.settings';
const light = matchMedia('(prefers-color-scheme: light)'), systemsTheme = () => (light.matches ? 'light' : 'dark');
const defaults = { turning: 'trackball', theme: 'auto', logAxis: true, cube: true, scale: true, colours: true,
                   box: true, slices: false, folded: null };

function stored() {
  try {
    return JSON.parse(localStorage.getItem(key)) ?? {};
  } catch {
    return {};  // no storage in this window, or not ours
  }
}

export const settings = { ...defaults, ...stored() };
const listeners = [];

export function onSettings(listener) {
  listeners.push(listener);
  listener();
}

export function set(part) {
  Object.assign(settings, part);
  try {
    localStorage.setItem(key, JSON.stringify(settings));
  } catch {
    // kept for this page only
  }
  for (const listener of listeners) listener();
}

const boxes = { 'show-cube': 'cube', 'show-scale': 'scale', 'show-colours': 'colours', 'show-box': 'box',
                'show-slices': 'slices', 'log-axis': 'logAxis' };

/** Ties the page's fields to the settings. */
export function attachSettings() {
  light.addEventListener('change', () => set({}));
  for (const [id, name] of Object.entries(boxes))
    byId(id).addEventListener('change', (event) => set({ [name]: event.target.checked }));
  for (const radio of document.getElementsByName('turning'))
    radio.addEventListener('change', () => set({ turning: radio.value }));
  byId('theme').addEventListener('change', (event) => set({ theme: event.target.value }));
  byId('fold').addEventListener('click', () => {
    set({ folded: true });
    byId('unfold').focus();
  });
  byId('unfold').addEventListener('click', () => {
    set({ folded: false });
    byId('fold').focus();
  });
  onSettings(() => {
    for (const [id, name] of Object.entries(boxes)) byId(id).checked = settings[name];
    for (const radio of document.getElementsByName('turning')) radio.checked = radio.value === settings.turning;
    byId('theme').value = settings.theme;
    document.documentElement.dataset.theme = settings.theme === 'auto' ? systemsTheme() : settings.theme;
    const folded = settings.folded ?? matchMedia('(max-width: 700px)').matches;
    document.body.classList.toggle('folded', folded);
    byId('unfold').setAttribute('aria-expanded', String(!folded));
  });
}
