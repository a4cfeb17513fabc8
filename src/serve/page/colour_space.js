// The colour spaces in which ParaView's maps interpolate; all colours are sRGB, 0 to 1. The same formulas as in
// the renderer (src/classify/colour_space.cpp).

import { clamp } from './dom.js';
import { linearOf, srgbOf } from './transfer_function.js';

const mix = (a, b, t) => a.map((c, k) => c + t * (b[k] - c));
const times = (rows, v) => rows.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);

function hsvOf([r, g, b]) {
  const high = Math.max(r, g, b), span = high - Math.min(r, g, b);
  if (!(span > 0)) return [0, 0, high];
  const sixths = high === r ? (g - b) / span : high === g ? 2 + (b - r) / span : 4 + (r - g) / span;
  return [((sixths + 6) % 6) / 6, span / high, high];
}
function fromHsv([h, s, v]) {
  return [5, 3, 1].map((offset) => {
    const k = (offset + 6 * h) % 6;
    return v - v * s * clamp(Math.min(k, 4 - k), 0, 1);
  });
}
function mixHsv(a, b, t, wrap) {
  const from = hsvOf(a), to = hsvOf(b);
  if (wrap && from[0] - to[0] > 0.5) to[0] += 1;
  else if (wrap && to[0] - from[0] > 0.5) from[0] += 1;
  const [h, s, v] = mix(from, to, t);
  return fromHsv([h - Math.floor(h), s, v]);
}

// CIE L*a*b* (CIE 15:2004) under D65.
const toXyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
const fromXyz = [[3.2406254773, -1.5372079722, -0.4986285987], [-0.9689307147, 1.8757560609, 0.0415175238],
                 [0.0557101204, -0.2040210506, 1.0569959423]];
const white = [0.9505, 1, 1.089];

function labOf(rgb) {
  const [x, y, z] = times(toXyz, linearOf(rgb)).map((c, k) => {
    const v = c / white[k];
    return v > 0.008856 ? Math.cbrt(v) : 7.787 * v + 16 / 116;
  });
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}
function fromLab([l, a, b]) {
  const y = (l + 16) / 116;
  const xyz = [a / 500 + y, y, y - b / 200].map((v, k) =>
    white[k] * (v ** 3 > 0.008856 ? v ** 3 : (v - 16 / 116) / 7.787));
  return srgbOf(times(fromXyz, xyz).map((c) => clamp(c, 0, 1)));
}

// Moreland's polar form of Lab (Moreland 2009, section 5): magnitude, saturation angle, hue.
function mshOf(rgb) {
  const [l, a, b] = labOf(rgb), m = Math.hypot(l, a, b);
  const s = m > 0.001 ? Math.acos(clamp(l / m, -1, 1)) : 0;
  return [m, s, s > 0.001 ? Math.atan2(b, a) : 0];
}
function adjustedHue([m, s, h], unsaturated) {
  if (m >= unsaturated) return h;
  const spin = (s * Math.sqrt(unsaturated ** 2 - m ** 2)) / (m * Math.sin(s));
  return h > -Math.PI / 3 ? h + spin : h - spin;
}
function mixDiverging(a, b, t) {
  const grey = 0.05;
  let from = mshOf(a), to = mshOf(b), apart = Math.abs(from[2] - to[2]);
  if (apart > Math.PI) apart = 2 * Math.PI - apart;
  if (from[1] > grey && to[1] > grey && apart > Math.PI / 3) {
    const middle = [Math.max(from[0], to[0], 88), 0, 0];
    if (t < 0.5) [to, t] = [middle, 2 * t];
    else [from, t] = [middle, 2 * t - 1];
  }
  if (from[1] < grey && to[1] > grey) from[2] = adjustedHue(to, from[0]);
  else if (to[1] < grey && from[1] > grey) to[2] = adjustedHue(from, to[0]);
  const [m, s, h] = mix(from, to, t);
  return fromLab([m * Math.cos(s), m * Math.sin(s) * Math.cos(h), m * Math.sin(s) * Math.sin(h)]);
}

/** By ParaView's name of the space; null for one that is not known. */
export function interpolation(name, hsvWrap) {
  const lab = (a, b, t) => fromLab(mix(labOf(a), labOf(b), t));
  const hsv = (a, b, t) => mixHsv(a, b, t, hsvWrap);
  const spaces = { RGB: mix, HSV: hsv, Lab: lab, CIELAB: lab, Diverging: mixDiverging };
  const mixed = Object.hasOwn(spaces, name) ? spaces[name] : null;
  return mixed && ((a, b, t) => mixed(a, b, t).map((c) => clamp(c, 0, 1)));
}
