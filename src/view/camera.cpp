#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "ringsplat/base/error.hpp"
#include "ringsplat/view/view.hpp"
#include "view/matrices.hpp"

namespace ringsplat {
namespace {

void check(const Camera& camera) {
  for (const auto& [name, degrees] :
       {std::pair("azimuth", camera.azimuth), std::pair("elevation", camera.elevation),
        std::pair("roll", camera.roll)})
    if (!std::isfinite(degrees))
      throw InputError(fmt::format("camera {} {} is not a finite angle", name, degrees),
                       "give degrees, for example 30");
  if (!std::isfinite(camera.zoom) || !(camera.zoom > 0))
    throw InputError(fmt::format("camera zoom {} is not positive and finite", camera.zoom),
                     "1 fits the volume to the image, 2 shows it twice as large");
  constexpr double most_pan = 1e6;
  for (const double shift : camera.pan)
    if (!(std::abs(shift) <= most_pan))
      throw InputError(fmt::format("the camera cannot be panned by {} pictures", shift),
                       "give lengths of the picture's shorter side, for example 0.25 -0.1");
  for (const auto& place : {camera.eye, camera.target})
    if (place && !is_finite(*place))
      throw InputError("the camera's eye or target is not finite", "give three world coordinates");
  if (!is_finite(camera.up) || !(safe_length(camera.up) > 0))
    throw InputError("the camera's up has no direction", "give three numbers, for example 0 0 1");
  if (camera.eye && camera.distance != 0)
    throw InputError("the camera's eye and its distance are both given", "leave out the distance");
}

void check_perspective(const Camera& camera) {
  if (camera.fov == 0 && camera.distance == 0) return;
  if (!(camera.fov >= 0.01 && camera.fov <= 179))
    throw InputError(fmt::format("a field of view of {} degrees cannot be drawn in perspective", camera.fov),
                     "give 0.01 to 179 degrees, for example 40; an orthographic camera has no distance");
  if (camera.distance != 0 && !(camera.distance > 0 && camera.distance <= 1e5))
    throw InputError(fmt::format("the eye cannot be {} radii from the volume's centre", camera.distance),
                     "give a distance above 0 and up to 1e5, in radii of the volume's bounding sphere");
  if (camera.matrix)
    throw InputError("a camera matrix is orthographic and has no field of view",
                     "give the perspective camera by angles");
}

/// Columns: the world vector from voxel to voxel along each lattice axis.
glm::dmat3 lattice_to_world(const LatticeFrame& lattice) {
  return {lattice.direction[0] * lattice.spacing.x, lattice.direction[1] * lattice.spacing.y,
          lattice.direction[2] * lattice.spacing.z};
}

/// Half of the extent of the volume's box along a world direction of unit length.
double half_extent(const LatticeFrame& lattice, const glm::dvec3& direction) {
  return 0.5 * glm::dot(glm::dvec3(lattice.dims), glm::abs(direction * lattice_to_world(lattice)));
}

/// Radius of the sphere about the volume's box, which ends half a voxel beyond the outer voxel centres.
double bounding_radius(const LatticeFrame& lattice) {
  const glm::dmat3 axes = lattice_to_world(lattice);
  const glm::dvec3 half = 0.5 * glm::dvec3(lattice.dims);
  double radius = 0;
  for (int corner = 0; corner < 4; ++corner)
    radius = std::max(
        radius, safe_length(axes * (half * glm::dvec3((corner & 1) ? -1 : 1, (corner & 2) ? -1 : 1, 1))));
  return radius;
}

/// Sets the picture's world axes for an eye that looks at a target; returns how far it is from there.
double look(ViewTransform& view, const Camera& camera, const glm::dvec3& target) {
  const glm::dvec3 from_target = *camera.eye - target;
  const double distance = safe_length(from_target);
  if (!(distance > 0))
    throw InputError("the camera's eye is where it looks at", "give an --eye away from the --target");
  view.to_viewer = unit(from_target);
  const glm::dvec3 right = glm::cross(unit(camera.up), view.to_viewer);
  constexpr double least_sine = 1e-9;
  if (!(glm::length(right) > least_sine))
    throw InputError("the camera looks along its own up", "give an --up across the view, for example 0 1 0");
  view.right = unit(right);
  view.up = glm::cross(view.to_viewer, view.right);
  return distance;
}

/// Sets the picture's world axes: right, up and to_viewer.
void turn(ViewTransform& view, const Camera& camera) {
  const auto azimuth = sin_cos_degrees(camera.azimuth);
  const auto elevation = sin_cos_degrees(camera.elevation);
  const auto roll = sin_cos_degrees(camera.roll);
  view.to_viewer = {elevation.cosine * azimuth.sine, -elevation.cosine * azimuth.cosine, elevation.sine};
  const glm::dvec3 right{azimuth.cosine, azimuth.sine, 0.0};
  const glm::dvec3 up{-elevation.sine * azimuth.sine, elevation.sine * azimuth.cosine, elevation.cosine};
  view.right = roll.cosine * right + roll.sine * up;
  view.up = roll.cosine * up - roll.sine * right;
}

/// From the box's centre to the eye whose view, `slope` half as wide as far, just holds the box's corners.
double fitting_distance(const ViewTransform& view, const LatticeFrame& lattice, int width, int height,
                        double slope) {
  const glm::dmat3 axes = lattice_to_world(lattice);
  const double side = std::min(width, height);
  double distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 sign((corner & 1) ? -0.5 : 0.5, (corner & 2) ? -0.5 : 0.5, (corner & 4) ? -0.5 : 0.5);
    const glm::dvec3 place = axes * (sign * glm::dvec3(lattice.dims));
    const double off_centre = std::max(std::abs(glm::dot(place, view.right)) * (side / width),
                                       std::abs(glm::dot(place, view.up)) * (side / height));
    distance = std::max(distance, glm::dot(place, view.to_viewer) + off_centre / (slope * box_fill));
  }
  return distance;
}

/// How far before the box's centre the point is that the camera turns about. The eye stays where it would be
/// without a target, and so outside of the box.
double nearer_by(const ViewTransform& view, const LatticeFrame& lattice, const glm::dvec3& point) {
  const glm::dvec3 from_centre = lattice_to_world(lattice) * (point - 0.5 * glm::dvec3(lattice.dims - 1));
  return std::min(glm::dot(from_centre, view.to_viewer), half_extent(lattice, view.to_viewer));
}

ViewTransform view_from_angles(const Camera& camera, const LatticeFrame& lattice, int width, int height) {
  ViewTransform view;
  // The point that the camera turns about, at depth 0, in lattice coordinates.
  glm::dvec3 centre = 0.5 * glm::dvec3(lattice.dims - 1);
  if (camera.target)
    centre = glm::inverse(lattice.direction) * (*camera.target - lattice.origin) / lattice.spacing;
  const double radius = bounding_radius(lattice);
  double distance = radius * camera.distance;  // in the world; 0: follows from the field of view
  if (camera.eye)
    distance = look(view, camera, lattice.origin + lattice_to_world(lattice) * centre);
  else
    turn(view, camera);
  const bool fits_box = camera.fit == Fit::box;
  const double side = std::min(width, height);
  // From the centre to the nearer edges of the picture at zoom 1.
  double shown = radius;
  if (fits_box)  // as if an orthographic view just held the box
    shown = std::max(half_extent(lattice, view.right) * (side / width),
                     half_extent(lattice, view.up) * (side / height)) /
            box_fill;
  if (camera.fov > 0) {
    const double slope = std::tan(0.5 * camera.fov * std::numbers::pi / 180);
    if (distance == 0 && fits_box)
      distance = fitting_distance(view, lattice, width, height, slope) - nearer_by(view, lattice, centre);
    if (distance > 0) shown = distance * slope;
    view.eye = centre + glm::inverse(lattice.direction) * (shown / slope * view.to_viewer) / lattice.spacing;
  }
  view.pixels_per_unit = camera.zoom * (0.5 * side / shown);
  const glm::dmat3 to_picture = glm::transpose(glm::dmat3(view.right, -view.up, -view.to_viewer));
  view.linear = view.pixels_per_unit * (to_picture * lattice_to_world(lattice));
  // The centre is subtracted in lattice coordinates, so a large world origin costs no precision.
  view.offset = glm::dvec3(0.5 * width + camera.pan[0] * side, 0.5 * height + camera.pan[1] * side, 0.0) -
                view.linear * centre;
  return view;
}

/// a · b + t as if computed with twice the precision (Ogita, Rump and Oishi 2005, Dot2): a translation
/// usually cancels a large origin.
double accurate_dot(const glm::dvec3& a, const glm::dvec3& b, double t) {
  double sum = t, rest = 0;
  for (int k = 0; k < 3; ++k) {
    const double product = a[k] * b[k];
    const double before = sum;
    sum += product;
    const double back = sum - before;
    rest += ((before - (sum - back)) + (product - back)) + std::fma(a[k], b[k], -product);
  }
  return sum + rest;
}

ViewTransform view_from_matrix(const std::array<double, 12>& m, const LatticeFrame& lattice) {
  const glm::dmat3 rows(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);  // as columns
  const glm::dvec3 translation{m[3], m[7], m[11]};
  if (!is_finite(rows) || !is_finite(translation))
    throw InputError("the camera matrix has a number that is not finite",
                     "give twelve finite numbers, row by row");
  if (spanned_volume(rows) < least_volume)
    throw InputError(
        "the camera matrix is singular",
        "its three rows (right, down, depth) must be independent; the depth row may not be zero");

  ViewTransform view;
  view.linear = glm::transpose(rows) * lattice_to_world(lattice);
  for (int r = 0; r < 3; ++r) view.offset[r] = accurate_dot(rows[r], lattice.origin, translation[r]);
  // Each column of the inverse is orthogonal to two of the rows, so it is parallel to their cross product.
  const glm::dmat3 unit_rows(unit(rows[0]), unit(rows[1]), unit(rows[2]));
  const double sign = glm::determinant(unit_rows) < 0 ? -1.0 : 1.0;
  view.right = unit(sign * glm::cross(unit_rows[1], unit_rows[2]));
  view.up = unit(-sign * glm::cross(unit_rows[2], unit_rows[0]));
  view.to_viewer = unit(-sign * glm::cross(unit_rows[0], unit_rows[1]));
  view.pixels_per_unit = std::cbrt(spanned_volume(rows)) * std::cbrt(safe_length(rows[0])) *
                         std::cbrt(safe_length(rows[1])) * std::cbrt(safe_length(rows[2]));
  return view;
}

/// Products of extreme but valid numbers can still overflow or underflow.
void check_representable(const ViewTransform& view) {
  const bool scale_ok = std::isfinite(view.pixels_per_unit) && view.pixels_per_unit > 0;
  bool columns_ok = true;
  for (int k = 0; k < 3; ++k) columns_ok = columns_ok && std::isnormal(largest_magnitude(view.linear[k]));
  if (!scale_ok || !columns_ok || !is_finite(view.linear) || !is_finite(view.offset) ||
      (view.eye && !is_finite(*view.eye)))
    throw InputError("the view maps voxels to pixels by numbers beyond double precision",
                     "use a zoom or a camera matrix nearer to the volume's size");
}

/// Stands in a world direction from the volume's middle, or from a target that is `beyond` it; the volume's
/// box fills the picture.
Camera standing_before(const LatticeFrame& lattice, const glm::dvec3& to_viewer, const glm::dvec3& beyond) {
  const glm::dvec3 extent = lattice.spacing * glm::dvec3(lattice.dims - 1);
  Camera camera{.zoom = 1 / box_fill, .fit = Fit::box};
  camera.target = lattice.origin + lattice.direction * (0.5 * extent) + beyond;
  camera.eye = *camera.target + glm::length(extent + lattice.spacing) * to_viewer;
  return camera;
}

}  // namespace

int nearest_axis(const glm::dvec3& direction) {
  const glm::dvec3 along = glm::abs(direction);
  return along.x >= along.y && along.x >= along.z ? 0 : along.y >= along.z ? 1 : 2;
}

Camera facing_slices(const LatticeFrame& lattice, Axis axis, bool patient) {
  const double side = patient ? -1 : 1;
  const glm::dvec3 to_viewer[] = {{1, 0, 0}, {0, -1, 0}, {0, 0, side}},
                   up[] = {{0, 0, 1}, {0, 0, 1}, {0, side, 0}};
  const auto towards = [](const glm::dvec3& direction, const glm::dvec3& wished) {
    return glm::dot(direction, wished) < 0 ? -direction : direction;
  };
  const glm::dvec3 normal = lattice.direction[int(axis)], one = lattice.direction[in_plane(axis).u],
                   other = lattice.direction[in_plane(axis).v];
  const int across = nearest_axis(normal);
  const bool other_is_up = std::abs(glm::dot(other, up[across])) > std::abs(glm::dot(one, up[across]));
  Camera camera = standing_before(lattice, towards(normal, to_viewer[across]), glm::dvec3(0.0));
  camera.up = towards(other_is_up ? other : one, up[across]);
  return camera;
}

Camera facing_plane(const LatticeFrame& lattice, const glm::dvec3& normal, double distance) {
  const glm::dvec3 to_viewer = unit(normal);
  Camera camera = standing_before(lattice, to_viewer, distance * to_viewer);
  constexpr double along_z = 0.999;
  if (std::abs(to_viewer.z) > along_z) camera.up = {0, 1, 0};
  return camera;
}

ViewTransform make_view(const Camera& camera, const LatticeFrame& lattice, int width, int height) {
  if (width < 1 || height < 1)
    throw InputError(fmt::format("an image of {} x {} pixels cannot be drawn", width, height),
                     "give a width and a height of at least 1");
  if (!camera.matrix) check(camera);
  if (camera.matrix && (camera.pan != std::array<double, 2>{} || camera.eye || camera.target))
    throw InputError("a camera matrix has no pan, eye or target", "add the pixels to its fourth column");
  check_perspective(camera);
  const ViewTransform view = camera.matrix ? view_from_matrix(*camera.matrix, lattice)
                                           : view_from_angles(camera, lattice, width, height);
  check_representable(view);
  return view;
}

double ViewTransform::magnification(const glm::dvec3& lattice) const {
  if (!eye) return 1;
  const double from_eye = -project(*eye).z, depth = from_eye + project(lattice).z;
  return depth > 0 ? from_eye / depth : std::numeric_limits<double>::infinity();
}

glm::dvec2 ViewTransform::seen_at(const glm::dvec3& lattice) const {
  const glm::dvec2 place = project(lattice);
  if (!eye) return place;
  const glm::dvec2 centre = project(*eye);
  return centre + magnification(lattice) * (place - centre);
}

}  // namespace ringsplat
