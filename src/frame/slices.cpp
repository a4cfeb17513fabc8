#include "frame/slices.hpp"

#include <algorithm>
#include <glm/matrix.hpp>

#include "frame/frame_geometry.hpp"

namespace ringsplat {

double before(const ClipPlane& plane, const Grid& grid, const glm::dvec3& place) {
  return glm::dot(glm::normalize(plane.normal), from_middle(grid, place)) - plane.distance;
}

ClipPlane plane_across(const Grid& grid, const glm::dvec3& direction, const glm::dvec3& place) {
  return {direction, glm::dot(direction, from_middle(grid, place))};
}

ClipPlane plane_along_slices(const Grid& grid, Axis axis, const glm::dvec3& place) {
  // The lattice may be oblique: its axes are not its slices' normals then.
  return plane_across(grid, glm::normalize(glm::transpose(glm::inverse(grid.direction))[int(axis)]), place);
}

std::vector<ClipPlane> planes_of_slice(const ClipPlane& plane, const Grid& grid) {
  const double voxels = std::max(1e-3, 2e-6 * std::max({grid.dims.x, grid.dims.y, grid.dims.z})),
               half = voxels * grid.unit_length();
  return {{plane.normal, plane.distance - half}, {-plane.normal, -plane.distance - half}};
}

void show_values(Shown& shown) {
  const bool labels = shown.interpolation == Interpolation::nearest;
  shown.edges.reset();
  shown.shading = Shading::none;
  shown.mode = labels ? Mode::composite : Mode::mip;
  for (auto& point : shown.transfer_function.opacities) point.opacity = labels && point.opacity == 0 ? 0 : 1;
}

CutOpen cut_open(const FrameSpec& spec, const Grid& grid) {
  CutOpen made{spec, spec};
  const glm::dvec3 normal = glm::normalize(spec.shown.cut->normal);
  const double distance = spec.shown.cut->distance;
  const ViewTransform view =
      make_view(spec.shown.camera, lattice_frame(grid), spec.shown.width, spec.shown.height);
  const double to_viewer =
      view.eye ? before(*spec.shown.cut, grid, *view.eye) : glm::dot(normal, view.to_viewer);
  made.left.shown.clip_planes.push_back(to_viewer > 0 ? ClipPlane{-normal, -distance}
                                                      : ClipPlane{normal, distance});
  Shown& slice = made.slice.shown;
  for (const ClipPlane& plane : planes_of_slice({normal, distance}, grid)) slice.clip_planes.push_back(plane);
  show_values(slice);
  auto& colours = slice.transfer_function.colours;
  const auto is_first = [&](const auto& point) { return point.srgb == colours.front().srgb; };
  // A surface's one colour would show no values.
  if (std::ranges::all_of(colours, is_first))
    colours = {{colours.front().value, glm::dvec3(0.0)}, {colours.back().value, glm::dvec3(1.0)}};
  slice.cut.reset();
  slice.mixed = false;
  slice.tints.clear();
  if (auto* const sheets = std::get_if<Sheets>(&made.slice.how)) sheets->layers = 0;
  return made;
}

}  // namespace ringsplat
