// Transfer functions as the state holds them: colours [[value, r, g, b] ...] in sRGB and opacities
// [[value, opacity] ...], ascending, linear between points and constant beyond. All functions give new ones.

import { clamp, fromHex, toHex } from './dom.js';

const toLinear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const toSrgb = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);

/** The points on both sides of a value and the share of the way between them. */
function between(points, value) {
  if (value <= points[0][0]) return [points[0], points[0], 0];
  const next = points.findIndex((p) => p[0] > value);
  if (next < 0) return [points.at(-1), points.at(-1), 0];
  const [a, b] = [points[next - 1], points[next]];
  return [a, b, (value - a[0]) / (b[0] - a[0])];
}

export function opacityAt(tf, value) {
  const [a, b, t] = between(tf.opacities, value);
  return a[1] + t * (b[1] - a[1]);
}

/** sRGB; linear light is interpolated, as the renderer does. */
export function colourAt(tf, value) {
  const [a, b, t] = between(tf.colours, value);
  const [from, to] = [a, b].map((point) => point.slice(1).map(toLinear));
  return from.map((c, k) => toSrgb(c + t * (to[k] - c)));
}

/** Gives a canvas's gradient the colours between two values. */
export function addColours(gradient, tf, [low, high]) {
  const steps = 64;
  for (let i = 0; i <= steps; ++i)
    gradient.addColorStop(i / steps, toHex(colourAt(tf, low + ((high - low) * i) / steps)));
  return gradient;
}

/** `which`: 'opacities' or 'colours'. Gives the function and the index of the new point. */
export function withPoint(tf, which, point) {
  const points = tf[which], next = points.findIndex((p) => p[0] > point[0]);
  const index = next < 0 ? points.length : next;
  return { tf: { ...tf, name: 'edited', [which]: points.toSpliced(index, 0, point) }, index };
}

/** Two points are the fewest. */
export const canLose = (tf, which) => tf[which].length > 2;

/** Puts a point elsewhere, but never past its neighbours. */
export function withPointAt(tf, which, index, point) {
  const points = tf[which];
  const low = points[index - 1]?.[0] ?? -Infinity, high = points[index + 1]?.[0] ?? Infinity;
  const kept = [clamp(point[0], low, high), ...point.slice(1).map((c) => clamp(c, 0, 1))];
  return { ...tf, name: 'edited', [which]: points.with(index, kept) };
}

/** The span in which something is done: the opacity points between their first and last. */
export function windowOf(tf) {
  const values = tf.opacities.map((p) => p[0]);
  const rising = tf.opacities.findIndex((p) => p[1] > 0);
  const low = values[Math.max(0, rising - 1)], high = values.at(-1);
  return { level: 0.5 * (low + high), width: high - low };
}

/** All points at other values: `place` of those that they have. */
function placed(tf, place) {
  const move = ([value, ...rest]) => [place(value), ...rest];
  return { ...tf, name: 'edited', colours: tf.colours.map(move), opacities: tf.opacities.map(move) };
}

/** Window and level: stretches all points about the window's middle and shifts them. */
export function stretched(tf, factor, shift) {
  const { level } = windowOf(tf);
  return placed(tf, (value) => level + shift + factor * (value - level));
}

/** The same, but the values below and above all that is visible stay transparent. */
export function windowed(tf, factor, shift) {
  const moved = stretched(tf, factor, shift), seen = tf.opacities.map((p) => p[1] > 0);
  const first = seen.indexOf(true), last = seen.lastIndexOf(true);
  const low = first > 0 ? tf.opacities[first - 1][0] : -Infinity;
  const high = last >= 0 && last + 1 < seen.length ? tf.opacities[last + 1][0] : Infinity;
  return { ...moved, opacities: moved.opacities.map(([value, opacity]) => [clamp(value, low, high), opacity]) };
}

/** All points over other values, from the first to the last. */
export function spread(tf, low, high) {
  const values = [...tf.colours, ...tf.opacities].map((p) => p[0]), first = Math.min(...values);
  const width = Math.max(...values) - first || 1;
  return placed(tf, (value) => low + ((value - first) / width) * (high - low));
}

/** A map's colours, evenly over the values that the function's colours cover now. */
export function withMap(tf, map) {
  const low = tf.colours[0][0], high = tf.colours.at(-1)[0];
  const colours = map.colours.map((rgb, i) => [low + ((high - low) * i) / (map.colours.length - 1), ...rgb]);
  return { ...tf, name: map.name, colours };
}

/** As ParaView reads it; the server reads ParaView's (message `map`). */
export function toParaView(tf) {
  const map = {
    ColorSpace: 'RGB',
    Name: tf.name,
    NanColor: [1, 0, 0],
    RGBPoints: tf.colours.flat(),
    Points: tf.opacities.flatMap(([value, opacity]) => [value, opacity, 0.5, 0]),
  };
  return JSON.stringify([map], null, 2) + '\n';
}

const fromDigits = (digits) => digits.split(' ').map((hex) => fromHex('#' + hex));

/** Perceptually even maps (viridis, inferno, plasma: matplotlib; cividis: Nuñez et al. 2018) and plain ones. */
export const maps = [
  { name: 'grey', colours: fromDigits('000000 ffffff') },
  { name: 'viridis', colours: fromDigits('440154 482878 3e4989 31688e 26828e 1f9e89 35b779 6ece58 b5de2b fde725') },
  { name: 'inferno', colours: fromDigits('000004 1b0c41 4a0c6b 781c6d a52c60 cf4446 ed6925 fb9b06 f7d13d fcffa4') },
  { name: 'plasma', colours: fromDigits('0d0887 46039f 7201a8 9c179e bd3786 d8576b ed7953 fb9f3a fdca26 f0f921') },
  { name: 'cividis', colours: fromDigits('00224e 123570 3b496c 575d6d 707173 8a8678 a59c74 c3b369 e1cc55 fee838') },
  { name: 'cool-warm', colours: fromDigits('3b4cc0 7b9ff9 c0d4f5 dddcdc f2cbb7 ee8468 b40426') },
  { name: 'skin', colours: fromDigits('b87a61 d69e80 f2c7a8 ffebd6') },
  { name: 'bone', colours: fromDigits('8c4026 ba734d e6d1a8 fffcf2') },
];
