// Reads and writes ParaView's JSON colour maps, as the program does.

import { interpolation } from './colour_space.js';
import { isTransferFunction } from './scene.js';

const samplesEachSpan = 16, piecesEachSide = 12, mostPoints = 512;  // that the server takes
const nearlyLinear = 0.01, nearlyStep = 0.99;                        // VTK's thresholds

function groups(map, field, size, otherwise) {
  const flat = map[field];
  if (flat === undefined || flat === null) throw new Error(otherwise);
  if (!Array.isArray(flat) || !flat.every(Number.isFinite)) throw new Error(`${field} is not a list of numbers`);
  if (flat.length % size) throw new Error(`${field}: ${flat.length} numbers are not a multiple of ${size}`);
  return Array.from({ length: flat.length / size }, (_, i) => flat.slice(i * size, (i + 1) * size));
}

function sampleColours(points, space, mixed) {
  if (space === 'RGB') return points;
  return points.flatMap((point, i) => {
    const next = points[i + 1];
    if (!next || !(point[0] < next[0])) return [point];
    return Array.from({ length: samplesEachSpan }, (_, k) => {
      const t = k / samplesEachSpan;
      return [point[0] + t * (next[0] - point[0]), ...mixed(point.slice(1), next.slice(1), t)];
    });
  });
}

/** VTK's curve (class vtkPiecewiseFunction) at half of the way `s`, its midpoint moved to 0.5. */
function shaped(y0, y1, sharpness, s) {
  const power = 1 + 10 * sharpness;
  const bent = s < 0.5 ? 0.5 * (2 * s) ** power : 1 - 0.5 * (2 * (1 - s)) ** power;
  const y = y0 + (y1 - y0) * bent * bent * (3 - 2 * bent) +
            (1 - sharpness) * (y1 - y0) * bent * (1 - bent) * (1 - 2 * bent);
  return Math.min(Math.max(y, Math.min(y0, y1)), Math.max(y0, y1));
}

/** Opacity pieces whose midpoint and sharpness are not 0.5 and 0 become several points. */
function sampleOpacities(points) {
  return points.flatMap(([value, opacity, given, sharpness], i) => {
    const next = points[i + 1];
    if (!next || !(value < next[0])) return [[value, opacity]];
    const midpoint = Math.min(Math.max(given, 1e-5), 1 - 1e-5);
    const at = (t) => value + t * (next[0] - value), middle = at(midpoint);
    if (sharpness > nearlyStep) return [[value, opacity], [middle, opacity], [middle, next[1]]];
    if (sharpness < nearlyLinear)
      return given === 0.5 ? [[value, opacity]] : [[value, opacity], [middle, 0.5 * (opacity + next[1])]];
    return Array.from({ length: 2 * piecesEachSide }, (_, k) => {
      const half = k / piecesEachSide;
      const t = half <= 1 ? half * midpoint : midpoint + (half - 1) * (1 - midpoint);
      return [at(t), shaped(opacity, next[1], sharpness, half / 2)];
    });
  });
}

/** Throws an Error that says what is wrong. */
export function fromParaView(text) {
  let map = JSON.parse(text);
  if (Array.isArray(map)) {
    if (map.length !== 1) throw new Error(`the file holds ${map.length} colour maps; keep the one to be used`);
    map = map[0];
  }
  if (typeof map !== 'object' || map === null) throw new Error('the file holds no colour map');
  const space = map.ColorSpace ?? 'RGB', mixed = interpolation(space, map.HSVWrap === true || map.HSVWrap === 1);
  if (!mixed) throw new Error(`the colour space "${space}" is not known; export the map from ParaView as RGB`);
  const colours = groups(map, 'RGBPoints', 4, 'the file has no RGBPoints');
  const opacities = groups(map, 'Points', 4, 'the file has no opacity Points; tick "Opacities" when exporting');
  if (opacities.some((p) => p.slice(2).some((share) => share < 0 || share > 1)))
    throw new Error('Points: a midpoint or sharpness is outside 0..1');
  const tf = { name: typeof map.Name === 'string' ? map.Name : 'unnamed',
               colours: sampleColours(colours, space, mixed), opacities: sampleOpacities(opacities) };
  if (!isTransferFunction(tf)) throw new Error('it needs two points at least, ascending, from 0 to 1');
  if (Math.max(tf.colours.length, tf.opacities.length) > mostPoints)
    throw new Error(`it has more than ${mostPoints} points`);
  return tf;
}

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
