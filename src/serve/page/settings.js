// What a person chose for the page itself, kept by the browser: overlays, the way of dragging, the theme.

import { byId } from './dom.js';

const key = 'ringsplat.settings';
const light = matchMedia('(prefers-color-scheme: light)'), systemsTheme = () => (light.matches ? 'light' : 'dark');
const defaults = { turning: 'trackball', theme: 'auto', logAxis: true, cube: true, scale: true, colours: true,
                   box: true, slices: false, oblique: false, folded: null };

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

/** Ties the page's fields to the settings that they name. */
export function attachSettings() {
  light.addEventListener('change', () => set({}));
  const fields = document.querySelectorAll('[data-setting]');
  for (const field of fields)
    field.addEventListener('change', () =>
      set({ [field.dataset.setting]: field.type === 'checkbox' ? field.checked : field.value }));
  for (const [id, other] of [['fold', 'unfold'], ['unfold', 'fold']])
    byId(id).addEventListener('click', () => {
      set({ folded: id === 'fold' });
      byId(other).focus();
    });
  onSettings(() => {
    for (const field of fields) {
      const value = settings[field.dataset.setting];
      if (field.type === 'select-one') field.value = value;
      else field.checked = field.type === 'radio' ? field.value === value : value;
    }
    document.documentElement.dataset.theme = settings.theme === 'auto' ? systemsTheme() : settings.theme;
    const folded = settings.folded ?? matchMedia('(max-width: 700px)').matches;
    document.body.classList.toggle('folded', folded);
    byId('unfold').setAttribute('aria-expanded', String(!folded));
  });
}
