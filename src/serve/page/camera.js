// The camera's geometry, as the renderer defines it: azimuth about world z, elevation, clockwise roll, zoom 1
// fits the bounding sphere to the shorter side, pan in lengths of the shorter side.

const degree = Math.PI / 180;
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const sum = (...terms) => [0, 1, 2].map((k) => terms.reduce((total, [s, v]) => total + s * v[k], 0));
export const length = (a) => Math.hypot(...a);

/** The picture's directions in the world: right, up, and to the viewer. */
export function basisOf({ azimuth, elevation, roll }) {
  const [sa, ca] = [Math.sin(azimuth * degree), Math.cos(azimuth * degree)];
  const [se, ce] = [Math.sin(elevation * degree), Math.cos(elevation * degree)];
  const [s, c] = [Math.sin(roll * degree), Math.cos(roll * degree)];
  const right = [ca, sa, 0], up = [-se * sa, se * ca, ce];
  return { right: sum([c, right], [s, up]), up: sum([c, up], [-s, right]), viewer: [ce * sa, -ce * ca, se] };
}

/** The angles of a basis. Straight above or below the volume, roll is 0 and azimuth says it all. */
export function anglesOf({ right, viewer }) {
  const elevation = Math.asin(Math.min(1, Math.max(-1, viewer[2]))) / degree;
  if (Math.hypot(viewer[0], viewer[1]) < 1e-9)
    return { azimuth: Math.atan2(right[1], right[0]) / degree, elevation: 90 * Math.sign(viewer[2]), roll: 0 };
  const azimuth = Math.atan2(viewer[0], -viewer[1]) / degree;
  const upright = basisOf({ azimuth, elevation, roll: 0 });
  return { azimuth, elevation, roll: Math.atan2(dot(right, upright.up), dot(right, upright.right)) / degree };
}

function turned(v, axis, angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  return sum([c, v], [s, cross(axis, v)], [(1 - c) * dot(axis, v), axis]);
}

/** Rolls a virtual ball: the side of the volume nearest to the viewer follows the hand. Angles in radians. */
function rollBall(camera, right, down) {
  const angle = Math.hypot(right, down);
  if (angle === 0) return camera;
  const basis = basisOf(camera);
  const axis = sum([right / angle, basis.up], [down / angle, basis.right]);
  const moved = { right: turned(basis.right, axis, -angle), viewer: turned(basis.viewer, axis, -angle) };
  return { ...camera, ...anglesOf(moved) };
}

/** Turns the volume about its own vertical axis and tilts it; it never rolls. Angles in radians. */
function turnTable(camera, right, down) {
  const [s, c] = [Math.sin(camera.roll * degree), Math.cos(camera.roll * degree)];
  const azimuth = wrapped(camera.azimuth - (c * right + s * down) / degree);
  const elevation = Math.min(90, Math.max(-90, camera.elevation + (c * down - s * right) / degree));
  return { ...camera, azimuth, elevation };
}

/** How a drag turns the camera: a virtual ball or a turntable. */
export const turning = { trackball: rollBall, turntable: turnTable };

/** The same angle in -180 to 180. */
const wrapped = (angle) => angle - 360 * Math.round(angle / 360);

/**
 * Zooms and rolls about a fixed point of the picture and moves it: what a pinch does. All in lengths of the
 * shorter side from the picture's middle, x right and y down; roll in degrees, clockwise.
 */
export function movePicture(camera, { at = [0, 0], shift = [0, 0], zoom = 1, roll = 0 }) {
  const factor = Math.min(Math.max(camera.zoom * zoom, 0.01), 1000) / camera.zoom;
  const [s, c] = [factor * Math.sin(roll * degree), factor * Math.cos(roll * degree)];
  const [x, y] = [camera.pan[0] - at[0], camera.pan[1] - at[1]];
  return { ...camera, zoom: camera.zoom * factor, roll: wrapped(camera.roll + roll),
           pan: [at[0] + c * x - s * y + shift[0], at[1] + s * x + c * y + shift[1]] };
}

/** The six views: the side that looks at the viewer, as letters of patients and of axes. */
export const sixViews = [
  { name: 'Front', patient: 'A', axis: '−y', azimuth: 0, elevation: 0 },
  { name: 'Back', patient: 'P', axis: 'y', azimuth: 180, elevation: 0 },
  { name: 'Left', patient: 'L', axis: 'x', azimuth: 90, elevation: 0 },
  { name: 'Right', patient: 'R', axis: '−x', azimuth: -90, elevation: 0 },
  { name: 'Top', patient: 'H', axis: 'z', azimuth: 0, elevation: 90 },
  { name: 'Bottom', patient: 'F', axis: '−z', azimuth: 0, elevation: -90 },
];

/** World vectors from voxel to voxel along the lattice's axes. */
const latticeAxes = (volume) =>
  [0, 1, 2].map((k) => volume.direction.slice(3 * k, 3 * k + 3).map((d) => d * volume.spacing[k]));

/** A lattice place in the world, but for its origin. */
export const inWorld = (volume, place) => sum(...latticeAxes(volume).map((axis, k) => [place[k], axis]));

/** The lattice place of a world vector from the volume's middle. */
export function placeOf(volume, world) {
  const [a, b, c] = latticeAxes(volume), sides = [cross(b, c), cross(c, a), cross(a, b)], whole = dot(a, sides[0]);
  return sides.map((side, k) => dot(side, world) / whole + 0.5 * (volume.dims[k] - 1));
}

export function boundingRadius(volume) {
  const corners = [[1, 1, 1], [1, -1, 1], [-1, 1, 1], [-1, -1, 1]];
  return Math.max(...corners.map((ends) => length(inWorld(volume, volume.dims.map((n, k) => 0.5 * n * ends[k])))));
}

/** How lattice points are seen in a picture of width by height. */
export function viewOf(camera, volume, width, height) {
  const axes = latticeAxes(volume), basis = basisOf(camera), side = Math.min(width, height);
  const slope = Math.tan(0.5 * camera.fov * degree), far = camera.fov > 0 && camera.distance > 0;
  // World lengths that the shorter side shows at zoom 1, at the depth of the volume's centre.
  const shown = 2 * boundingRadius(volume) * (far ? camera.distance * slope : 1);
  const pixelsPerUnit = camera.zoom * side / shown, eye = camera.fov > 0 ? 0.5 * shown / slope : Infinity;
  const centre = [0.5 * width + camera.pan[0] * side, 0.5 * height + camera.pan[1] * side];
  const project = (lattice) => {
    const world = sum(...lattice.map((l, k) => [l - 0.5 * (volume.dims[k] - 1), axes[k]]));
    const near = dot(basis.viewer, world);
    const scale = pixelsPerUnit * (eye === Infinity ? 1 : eye / Math.max(eye - near, 1e-9));
    return [centre[0] + scale * dot(basis.right, world), centre[1] - scale * dot(basis.up, world), near];
  };
  return { ...basis, pixelsPerUnit, centre, project };
}

/** The zoom at which the volume's box, as it is seen, fills 95 % of the picture's width or height. */
export function fillingZoom(camera, volume, width, height) {
  const { project, centre } = viewOf({ ...camera, zoom: 1 }, volume, width, height);
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) =>
    project(volume.dims.map((n, k) => ((bits >> k) & 1 ? n - 0.5 : -0.5))));
  const reach = (k) => Math.max(...corners.map((corner) => Math.abs(corner[k] - centre[k])));
  return 0.475 * Math.min(width / reach(0), height / reach(1));
}

/** A camera's rotation, about z, x and z again, as a unit quaternion [w, x, y, z]. */
export function quaternionOf({ azimuth, elevation, roll }) {
  const [a, e, r] = [azimuth, 90 - elevation, roll].map((angle) => 0.5 * angle * degree);
  const [s, c] = [Math.sin(e), Math.cos(e)];
  return [c * Math.cos(a + r), s * Math.cos(a - r), s * Math.sin(a - r), c * Math.sin(a + r)];
}
export function basisOfQuaternion([w, x, y, z]) {
  const rotate = (v) => {
    const t = cross([x, y, z], v).map((c) => 2 * c);
    return sum([1, v], [w, t], [1, cross([x, y, z], t)]);
  };
  return { right: rotate([1, 0, 0]), up: rotate([0, 1, 0]), viewer: rotate([0, 0, 1]) };
}
