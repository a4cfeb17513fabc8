// What is drawn over the picture: the clip box's edges, scale bar, colour bar or legend and the probe's cross.

import { byId, clamp, fitCanvas, niceStep, show, toHex } from './dom.js';
import { settings } from './settings.js';
import { addColours } from './transfer_function.js';

const margin = 16, foot = 10;

/** Dark text on a light background and the other way. */
export function ink(background) {
  const light = 0.299 * background[0] + 0.587 * background[1] + 0.114 * background[2] > 0.55;
  return { text: light ? '#15171a' : '#f2f4f7', halo: light ? 'rgb(255 255 255 / .7)' : 'rgb(0 0 0 / .7)' };
}

export function write(context, colours, text, x, y) {
  context.lineWidth = 3;
  context.lineJoin = 'round';
  context.strokeStyle = colours.halo;
  context.strokeText(text, x, y);
  context.fillStyle = colours.text;
  context.fillText(text, x, y);
}

/** Makes lines the path, each through its points. */
export function trace(context, ...lines) {
  context.beginPath();
  for (const line of lines) line.forEach((point, k) => (k ? context.lineTo(...point) : context.moveTo(...point)));
}

export function strokeTwice(context, colours) {
  context.lineWidth = 4;
  context.strokeStyle = colours.halo;
  context.stroke();
  context.lineWidth = 1.5;
  context.strokeStyle = colours.text;
  context.stroke();
}

function drawScaleBar(context, colours, { bar, unit, perspective, height }) {
  const y = height - foot - 8, right = margin + bar.pixels;
  trace(context, [[margin, y - 5], [margin, y], [right, y], [right, y - 5]]);
  strokeTwice(context, colours);
  context.textBaseline = 'bottom';
  const words = `${show(bar.length)}${unit ? ' ' + unit : ' units'}${perspective ? ' at the centre' : ''}`;
  write(context, colours, words, margin + 4, y - 5);
}

/** Returns where its upper end is. */
function drawColourBar(context, colours, tf, [low, high], height) {
  const tall = clamp(height * 0.3, 80, 200), top = height - foot - 44 - tall, wide = 12;
  context.fillStyle = addColours(context.createLinearGradient(0, top + tall, 0, top), tf, [low, high]);
  context.fillRect(margin, top, wide, tall);
  context.lineWidth = 1;
  context.strokeStyle = colours.text;
  context.strokeRect(margin - 0.5, top - 0.5, wide + 1, tall + 1);
  context.textBaseline = 'middle';
  if (!(high > low)) return top;
  const step = niceStep(high - low, Math.max(2, Math.floor(tall / 32)));
  for (let k = Math.ceil(low / step - 1e-6); k * step <= high + 1e-6 * step; ++k) {
    const y = top + tall * (1 - (k * step - low) / (high - low));
    context.fillStyle = colours.text;
    context.fillRect(margin + wide, y - 0.5, 4, 1);
    write(context, colours, show(k * step), margin + wide + 7, y);
  }
  return top;
}

/** From above down to `bottom`, each name behind a piece of its colour; of too many the last line says how many more. */
function drawLegend(context, colours, all, bottom) {
  const step = 18, most = Math.max(1, Math.floor(bottom * 0.6 / step));
  const rows = all.length > most ? [...all.slice(0, most - 1), { name: `and ${all.length - most + 1} more` }] : all;
  context.textBaseline = 'middle';
  rows.forEach(({ name, colour }, k) => {
    const y = bottom - step * (rows.length - k);
    context.lineWidth = 1;
    context.fillStyle = colour ? toHex(colour) : 'transparent';
    context.fillRect(margin, y, 12, 12);
    context.strokeStyle = colours.text;
    if (colour) context.strokeRect(margin - 0.5, y - 0.5, 13, 13);
    write(context, colours, name, margin + (colour ? 19 : 0), y + 6);
  });
}

/** Of a box: each from one corner to another, by the ends of its sides. */
const edges = [0, 1, 2].flatMap((axis) => [[0, 0], [0, 1], [1, 0], [1, 1]].map((ends) =>
  [0, 1].map((end) => ends.toSpliced(axis, 0, end))));

function drawBox(context, colours, clip, project) {
  trace(context, ...edges.map((edge) => edge.map((ends) => project(ends.map((end, k) => clip[k][end] - 0.5)))));
  context.globalAlpha = 0.55;
  context.lineWidth = 1;
  context.strokeStyle = colours.text;
  context.stroke();
  context.globalAlpha = 1;
}

function drawCross(context, colours, [x, y]) {
  trace(context, ...[[1, 0], [-1, 0], [0, 1], [0, -1]].map((way) =>
    [3, 10].map((far) => [x + far * way[0], y + far * way[1]])));
  strokeTwice(context, colours);
}

function drawRuler(context, colours, places, words) {
  trace(context, places);
  strokeTwice(context, colours);
  for (const [x, y] of places) context.fillRect(x - 3, y - 3, 6, 6);
  context.textBaseline = 'bottom';
  words.forEach((text, k) => {
    const [a, b] = [places[k], places[k + 1]];
    write(context, colours, text, 0.5 * (a[0] + b[0]) + 6, 0.5 * (a[1] + b[1]) - 6);
  });
}

/** `seen`: pixelsPerUnit and project in CSS pixels of the stage; `slices`: as boxes; `ruler`: its places and words; `legend`: names and colours; `differs`: the picture is a difference, whose colours stand for no values. Returns the scale bar that was drawn. */
export function drawOverlay({ state, volume, seen, cross, slices, ruler, legend, differs, errors }) {
  const { context, width, height } = fitCanvas(byId('overlay'));
  if (errors) {
    context.imageSmoothingEnabled = false;
    context.drawImage(errors.bitmap, 0, 0, width, height);
  }
  const colours = ink(state.background), project = (place) => seen.project(place).slice(0, 2);
  context.font = '12px system-ui, sans-serif';
  let bar = null;
  if (state.clip && settings.box) drawBox(context, colours, state.clip, project);
  for (const box of slices) drawBox(context, colours, box, project);
  if (settings.scale) {
    // Round numbers have round inverses: this is the longest round length that fits.
    const length = 1 / niceStep(seen.pixelsPerUnit, clamp(width * 0.25, 60, 200));
    bar = { length, pixels: length * seen.pixelsPerUnit };
    drawScaleBar(context, colours, { bar, unit: volume.unit, perspective: state.camera.fov > 0, height });
  }
  let bottom = height - foot - 34;
  const { low, high } = volume.histogram;
  if (errors) drawColourBar(context, colours, errors.colours, [0, errors.colours.colours.at(-1)[0]], height);
  else if (settings.colours && !differs && !volume.labels.length && !state.channels.length)
    bottom = drawColourBar(context, colours, state.transfer_function, [low, high], height) - 10;
  if (settings.colours && !differs && !errors) drawLegend(context, colours, legend, bottom);
  if (ruler.places.length > 1) drawRuler(context, colours, ruler.places.map(project), ruler.words);
  if (cross) drawCross(context, colours, cross);
  return bar;
}
