// Small helpers for the page's elements.

export const byId = (id) => document.getElementById(id);

/** Makes an element; keys that begin with "on" are listeners, others are attributes. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    if (key.startsWith('on')) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value === true ? '' : value);
  }
  made.append(...children);
  return made;
}

/** A number for people: short, but with enough digits to be told from its neighbours. */
export function show(value, digits = 4) {
  if (!Number.isFinite(value)) return '–';
  return String(Number(value.toPrecision(digits)));
}

export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

/** Calls `take` with a number field's value once it is a whole, valid entry; otherwise puts the old one back. */
export function onNumber(field, take, refresh) {
  field.addEventListener('change', () => {
    const value = field.valueAsNumber;
    if (Number.isFinite(value)) take(clamp(value, field.min === '' ? -Infinity : Number(field.min),
                                           field.max === '' ? Infinity : Number(field.max)));
    refresh();
  });
}

/** Sizes a canvas to its place in device pixels; gives a context whose unit is a CSS pixel. */
export function fitCanvas(canvas) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  const columns = Math.max(1, Math.round(width * ratio)), rows = Math.max(1, Math.round(height * ratio));
  if (canvas.width !== columns || canvas.height !== rows) [canvas.width, canvas.height] = [columns, rows];
  const context = canvas.getContext('2d');
  context.setTransform(columns / Math.max(width, 1), 0, 0, rows / Math.max(height, 1), 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

/** The value of one of the style sheet's colours. */
export const themeColour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export const toHex = (rgb) =>
  '#' + rgb.map((c) => Math.round(clamp(c, 0, 1) * 255).toString(16).padStart(2, '0')).join('');
export const fromHex = (text) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255);

/** Offers bytes to the person as a file. */
export function download(name, blob) {
  const url = URL.createObjectURL(blob);
  element('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60000);
}

/** Steps of 1, 2 or 5 times a power of ten, at most `most` of them in `span`. */
export function niceStep(span, most) {
  const rough = span / most, power = 10 ** Math.floor(Math.log10(rough));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= rough * (1 - 1e-9));
}
