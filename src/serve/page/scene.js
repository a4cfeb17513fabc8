// The scene's state, who is told of its changes, and its forms as text: the URL's fragment and a JSON file.

import { byId } from './dom.js';

export const mostPlanes = 2;

const isNumbers = (list, count) => Array.isArray(list) && list.length === count && list.every(Number.isFinite);
const areShares = (list) => list.every((c) => c >= 0 && c <= 1);
const isRgb = (list) => isNumbers(list, 3) && areShares(list);
const arePoints = (list, size) => Array.isArray(list) && list.length >= 2 && list.every((p, i) =>
  isNumbers(p, size) && areShares(p.slice(1)) && (i === 0 || p[0] >= list[i - 1][0]));

const checks = {
  camera: (c) => typeof c === 'object' && c !== null && Object.entries(c).every(([key, value]) =>
    (key === 'pan' ? isNumbers(value, 2) : Number.isFinite(value)) && (key !== 'zoom' || value > 0)),
  transfer_function: (tf) =>
    typeof tf === 'object' && tf !== null && arePoints(tf.colours, 4) && arePoints(tf.opacities, 2),
  mode: (m) => [...byId('mode').options].some(({ value }) => value === m),
  isovalue: Number.isFinite,
  materials: (m) => typeof m === 'boolean',
  shading: (s) => s === 'phong' || s === 'none',
  light: (l) => isNumbers(l, 3) && Math.hypot(...l) > 0,
  clip: (b) => b === null || (Array.isArray(b) && b.length === 3 &&
                              b.every((range) => isNumbers(range, 2) && range[0] < range[1])),
  clip_planes: (all) => Array.isArray(all) && all.length <= mostPlanes &&
    all.every((plane) => isNumbers(plane, 4) && Math.hypot(...plane.slice(0, 3)) > 0),
  cut: (c) => c === null || (isNumbers(c, 4) && [0, 1, 2, 3].includes(c[0])),
  background: isRgb,
  channels: (all) => Array.isArray(all) && all.every((c) => typeof c?.visible === 'boolean' && isRgb(c.colour) &&
    isNumbers(c.window, 2) && c.window[0] <= c.window[1]),
  tints: (all) => Array.isArray(all) && all.every((tint) => isNumbers(tint, 5) && isRgb(tint.slice(1, 4))),
  frame: (f) => Number.isInteger(f) && f >= 0,
  compare: (f) => f === null || (Number.isInteger(f) && f >= 0),
  difference: (gain) => [0, 1, 4, 16].includes(gain),
  ruler: (places) => Array.isArray(places) && places.length <= 3 && places.every((place) => isNumbers(place, 3) &&
    place.every((p) => Math.abs(p) <= 1e6)),
};

/** Keeps the known, valid members of a state from outside; names the others. */
export function checkedState(given) {
  const state = {}, refused = [];
  if (typeof given !== 'object' || given === null) return { state, refused: ['all of it'] };
  for (const [key, check] of Object.entries(checks)) {
    if (!(key in given)) continue;
    if (check(given[key])) state[key] = given[key];
    else refused.push(key);
  }
  return { state, refused };
}

const rounded = (key, value) => (typeof value === 'number' ? Number(value.toPrecision(7)) : value);
const sameText = (a, b) => JSON.stringify(a, rounded) === JSON.stringify(b, rounded);

export class Scene {
  /** `onChange` gets the names of the members that became others. Without defaults until the server has said hello. */
  constructor(onChange) {
    this.onChange = onChange;
    this.state = null;
    this.defaults = null;
    this.locked = false;  // while another page drives
  }

  /** Takes the server's initial scene; what `kept` has stays. */
  begin(defaults, kept = {}) {
    this.defaults = { ruler: [], ...defaults };
    this.state = { ...this.defaults, ...kept, camera: { ...defaults.camera, ...kept.camera } };
    this.onChange(Object.keys(this.state));
  }

  /** Lays the page's own ruler, which no picture waits for, through these places. */
  measure(ruler) {
    if (this.state) this.state = { ...this.state, ruler };
  }

  /** Replaces some members; a camera may be given in part. */
  change(part) {
    if (!this.state || this.locked) return;
    const camera = part.camera ? { ...this.state.camera, ...part.camera } : this.state.camera;
    this.state = { ...this.state, ...part, camera };
    this.onChange(Object.keys(part));
  }

  /** The members that differ from the defaults. */
  differences() {
    const out = {};
    for (const [key, value] of Object.entries(this.state))
      if (!sameText(value, this.defaults[key])) out[key] = value;
    if (out.camera)
      out.camera = Object.fromEntries(Object.entries(out.camera).filter(
        ([key, value]) => !sameText(value, this.defaults.camera[key])));
    return out;
  }

  fragment() {
    const differences = this.differences();
    return Object.keys(differences).length ? 'state=' + encodeURIComponent(JSON.stringify(differences, rounded)) : '';
  }

  /** As a file: the whole scene and the film's key frames. */
  toFile(keyFrames) {
    const file = keyFrames.length ? { ...this.state, key_frames: keyFrames } : this.state;
    return JSON.stringify(file, rounded, 2) + '\n';
  }
}

/** What the address brings: a token, a state, or both (`TOKEN&state=...`); null where there is none. */
export function readFragment(hash) {
  const { state = 'null', token, ...bare } = Object.fromEntries(new URLSearchParams(hash.slice(1)));
  const out = { token: token ?? Object.keys(bare)[0] ?? null };
  try {
    out.state = JSON.parse(state);
  } catch {
    // there is one, but it cannot be read
  }
  return out;
}
