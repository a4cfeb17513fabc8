// A way through key frames: Catmull-Rom splines, for directions of quaternions.

import { anglesOf, basisOfQuaternion, quaternionOf } from './camera.js';
import { clamp } from './dom.js';

/** Uniform Catmull-Rom between b and c, for lists of numbers. */
function curve(a, b, c, d, t) {
  return b.map((_, k) => {
    const [p, q, r, s] = [a[k], b[k], c[k], d[k]];
    return 0.5 * (2 * q + t * (r - p + t * (2 * p - 5 * q + 4 * r - s + t * (3 * q - p - 3 * r + s))));
  });
}

/** q and -q are the same direction: each takes the sign nearest to the one before. */
function aligned(quaternions) {
  let before = quaternions[0];
  return quaternions.map((q) => {
    const same = q.reduce((total, c, k) => total + c * before[k], 0) >= 0;
    return (before = same ? q : q.map((c) => -c));
  });
}

function direction(cameras, t) {
  const q = curve(...aligned(cameras.map((camera) => quaternionOf(camera))), t), size = Math.hypot(...q);
  return anglesOf(basisOfQuaternion(q.map((c) => c / size)));
}

function camera(four, t) {
  const smooth = (read) => curve(...four.map(read), t);
  const [zoom] = smooth((c) => [Math.log(c.zoom)]), pan = smooth((c) => c.pan);
  const nearer = four[t < 0.5 ? 1 : 2];
  const perspective = four[1].fov > 0 && four[2].fov > 0;
  const fov = perspective ? clamp(smooth((c) => [c.fov || four[1].fov])[0], 0.01, 179) : nearer.fov;
  const far = perspective && four.every((c) => c.distance > 0);
  const distance = far ? Math.exp(smooth((c) => [Math.log(c.distance)])[0]) : nearer.distance;
  return { ...direction(four, t), zoom: Math.exp(zoom), pan, fov, distance };
}

/** Points of the same number move; other functions change halfway. */
function transferFunction(four, t) {
  const nearer = four[t < 0.5 ? 1 : 2];
  const points = (which) => {
    if (!four.every((tf) => tf[which].length === four[1][which].length)) return nearer[which];
    const flat = curve(...four.map((tf) => tf[which].flat()), t), size = nearer[which][0].length;
    let before = -Infinity;
    return nearer[which].map((_, i) => {
      const [value, ...rest] = flat.slice(i * size, (i + 1) * size);
      before = Math.max(before, value);
      return [before, ...rest.map((c) => clamp(c, 0, 1))];
    });
  };
  return { name: nearer.name, colours: points('colours'), opacities: points('opacities') };
}

function clipBox(four, t, dims) {
  if (four[1] === null && four[2] === null) return null;
  const flat = curve(...four.map((clip) => (clip ?? dims.map((n) => [0, n])).flat()), t).map(Math.round);
  return dims.map((n, k) => {
    const low = clamp(flat[2 * k], 0, n - 1);
    return [low, clamp(flat[2 * k + 1], low + 1, n)];
  });
}

/** A cut moves along the same slices; others change halfway. */
function cutOpen(four, t) {
  const moves = four.every((cut) => cut?.[0] === four[1]?.[0]) && four[1];
  return moves ? curve(...four, t).map((c) => Math.max(c, 0)) : four[t < 0.5 ? 1 : 2];
}

/** The scene at `time` (0 at the first key frame, 1 at the second ...). */
export function sceneAt(frames, time, dims) {
  const first = clamp(Math.floor(time), 0, Math.max(0, frames.length - 2)), t = clamp(time - first, 0, 1);
  const four = [-1, 0, 1, 2].map((k) => frames[clamp(first + k, 0, frames.length - 1)]);
  const light = curve(...four.map((f) => f.light), t);
  return {
    ...four[t < 0.5 ? 1 : 2],
    camera: camera(four.map((f) => f.camera), t),
    transfer_function: transferFunction(four.map((f) => f.transfer_function), t),
    isovalue: curve(...four.map((f) => [f.isovalue]), t)[0],
    frame: Math.round((1 - t) * four[1].frame + t * four[2].frame),
    light: Math.hypot(...light) > 1e-6 ? light : four[1].light,
    clip: clipBox(four.map((f) => f.clip), t, dims),
    cut: cutOpen(four.map((f) => f.cut), t),
    background: curve(...four.map((f) => f.background), t).map((c) => clamp(c, 0, 1)),
  };
}
