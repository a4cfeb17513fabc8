#include "serve/viewer.hpp"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "base/process.hpp"
#include "classify/auto_preset.hpp"
#include "frame/slices.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {

LoadOptions needed_for_levels(const FrameSpec& frame, const Grid& grid) {
  LoadOptions load = needed_along(frame, {true, true, true});
  load.factors.clear();
  load.clip.reset();  // pages move it
  for (const Level& level : make_levels(grid.dims))
    if (std::find(load.factors.begin(), load.factors.end(), level.undersample) == load.factors.end())
      load.factors.push_back(level.undersample);
  return load;
}

VoxelBox seen_box(const SceneState& scene, const Grid& grid) {
  const Shown& shown = scene.shown;
  const VoxelBox all = shown.clip.value_or(whole_box(grid));
  const ViewTransform view = make_view(shown.camera, lattice_frame(grid), shown.width, shown.height);
  // Cells of some voxels each are seen as balls round their middles.
  const glm::ivec3 cell = (all.dims() + 63) / 64;
  const double world_radius = 0.5 * glm::length(grid.spacing * glm::dvec3(cell));
  double radius = 0;
  for (int k = 0; k < 3; ++k) radius += 0.5 * cell[k] * glm::length(glm::dvec2(view.linear[k]));
  const auto is_cut = [&](const glm::dvec3& middle) {
    return std::ranges::any_of(shown.clip_planes, [&](const ClipPlane& plane) {
      return before(plane, grid, middle) < -world_radius;
    });
  };
  const auto is_in_picture = [&](const glm::dvec3& middle) {
    const double larger = view.magnification(middle);
    if (!std::isfinite(larger)) return false;
    const glm::dvec2 pixel = view.seen_at(middle), beyond(larger * radius);
    return glm::all(glm::greaterThanEqual(pixel, -beyond)) &&
           glm::all(glm::lessThanEqual(pixel, glm::dvec2(shown.width, shown.height) + beyond));
  };
  VoxelBox seen{all.end, all.first};
  glm::ivec3 at;
  for (at.z = all.first.z; at.z < all.end.z; at.z += cell.z)
    for (at.y = all.first.y; at.y < all.end.y; at.y += cell.y)
      for (at.x = all.first.x; at.x < all.end.x; at.x += cell.x)
        if (const auto middle = glm::dvec3(at) + 0.5 * glm::dvec3(cell) - 0.5;
            is_in_picture(middle) && !is_cut(middle))
          seen = {glm::min(seen.first, at), glm::max(seen.end, glm::min(at + cell, all.end))};
  if (glm::any(glm::lessThanEqual(seen.end, seen.first)))
    throw InputError("the picture shows nothing of the volume", "move the volume back into it");
  return seen;
}

int largest_side() {
  constexpr int most = 4096, least = 1024;
  const double machine = machine_memory_bytes();
  int side = most;
  while (side > least && 64.0 * side * side > machine / 4) side /= 2;
  return side;
}

void set_modes(const TransferFunction& usual, const ValueStatistics& values, ViewerOptions& options) {
  Shown& shown = options.initial.shown;
  if (shown.interpolation == Interpolation::nearest) return;
  if (shown.mode != Mode::surface) shown.isovalue = parting_value(values);
  for (const Mode mode : every_mode)
    options.modes.emplace_back(
        mode, mode == Mode::composite ? usual : choose_for_mode(mode, values, std::nullopt).function);
}

}  // namespace ringsplat::serve
