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

/** A function that has `act` called once before the screen's next frame, however often it is called. */
export function onceAFrame(act) {
  const ask = () => {
    if (ask.waits) return;
    ask.waits = true;
    requestAnimationFrame(() => {
      ask.waits = false;
      act();
    });
  };
  return ask;
}

/** A slider with two thumbs, which have `names`, between number fields of `unit`: take(end, value) gets what is put. */
export function dualSlider(app, names, unit, step, take) {
  const inputs = (type) => names.map((name, end) => element('input', {
    type, step, 'aria-label': type === 'range' ? name : `${name}, ${unit}`,
    [type === 'range' ? 'oninput' : 'onchange']: ({ target }) => {
      if (type === 'range') app.sender.pulse();
      take(end, target.valueAsNumber);
    },
  }));
  const ranges = inputs('range'), numbers = inputs('number'), inside = element('div', { class: 'inside' });
  const display = (window, [low, high], disabled = false) => {
    window.forEach((value, end) => {
      Object.assign(ranges[end], { min: low, max: high, value, disabled });
      Object.assign(numbers[end], { value: show(value, 5), disabled });
    });
    const percent = (value) => (100 * (value - low)) / (high - low || 1);
    inside.style.left = `${percent(window[0])}%`;
    inside.style.width = `${percent(window[1]) - percent(window[0])}%`;
  };
  return { parts: [numbers[0], element('div', { class: 'dual' }, inside, ...ranges), numbers[1]],
           second: [ranges[1], numbers[1]], display };
}

/** A drag by the first button or a finger, with which the scene moves: begin(event), move(event) and end(). */
export function onDrag(app, target, { begin, move, end }) {
  let held = false;
  target.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || !app.scene.state) return;
    event.preventDefault();
    target.focus({ focusVisible: false });
    target.setPointerCapture(event.pointerId);
    app.sender.hold();
    held = true;
    begin(event);
  });
  target.addEventListener('pointermove', (event) => held && move(event));
  for (const over of ['pointerup', 'pointercancel'])
    target.addEventListener(over, () => {
      if (!held) return;
      held = false;
      end?.();
      app.sender.release();
    });
}

/** Single keys of an element that has the focus: acts[key](event), which go no further. */
export function onKeys(app, target, acts) {
  target.addEventListener('keydown', (event) => {
    if (!acts[event.key] || event.ctrlKey || event.altKey || event.metaKey || !app.scene.state) return;
    event.preventDefault();
    event.stopPropagation();
    acts[event.key](event);
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

export const themeColour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Colours as style sheets and colour fields have them. */
export const toHex = (rgb) =>
  '#' + rgb.map((c) => Math.round(clamp(c, 0, 1) * 255).toString(16).padStart(2, '0')).join('');
export const fromHex = (text) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255);

/** Calls `take` with each colour that is tried in a colour field. */
export const onColour = (app, field, take) => field.addEventListener('input', () => {
  app.sender.pulse();
  take(fromHex(field.value));
});

/** Offers bytes to the person as a file. */
export function download(name, blob) {
  const url = URL.createObjectURL(blob);
  element('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60000);
}

/** Asks for a file; undefined when none was chosen. */
export function openFile(accept) {
  return new Promise((resolve) => {
    const input = element('input', { type: 'file', accept, class: 'unseen', 'aria-label': 'File' });
    for (const end of ['change', 'cancel'])
      input.addEventListener(end, () => {
        input.remove();
        resolve(input.files[0]);
      });
    document.body.append(input);
    input.click();
  });
}

/** A file's name of what the volume is called: letters that every system takes. */
export const fileStem = (name) => (name.replace(/\.(nrrd|nhdr|mhd|mha|nii|nii\.gz|raw|vtk|tiff?)$/i, '')
  .replace(/[^\p{L}\p{N}._-]+/gu, '-').slice(0, 80) || 'volume');

/** Steps of 1, 2 or 5 times a power of ten, at most `most` of them in `span`. */
export function niceStep(span, most) {
  const rough = span / most, power = 10 ** Math.floor(Math.log10(rough));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= rough * (1 - 1e-9));
}
