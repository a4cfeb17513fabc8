#include "sheet_engine/block_windows.hpp"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

constexpr double everywhere = 1e9;

/// As std::floor, which is a call where processors need not know it; blocks ask for it four times each.
int floored(double x) {
  const double limited = std::clamp(x, -everywhere, everywhere);
  const int whole = static_cast<int>(limited);
  return whole - (whole > limited ? 1 : 0);
}

/// Where a view shows a lattice point, times its depth, and that depth: linear in the points. An orthographic
/// view has depth 1.
glm::dvec3 homogeneous(const ViewTransform& view, const glm::dvec3& lattice) {
  const glm::dvec3 place = view.project(lattice);
  if (!view.eye) return {place.x, place.y, 1};
  const glm::dvec3 eye = view.project(*view.eye);
  const double depth = place.z - eye.z;
  return {eye.x * depth - eye.z * (place.x - eye.x), eye.y * depth - eye.z * (place.y - eye.y), depth};
}

/// `before` and `after` are in the order of the traversal.
BlockWindows windows_of_slab(const FrameGeometry& g, double before, double after, int finer) {
  if (!g.traversal.ascending) std::swap(before, after);
  return {g, 1.0, before, after, finer};
}

}  // namespace

SlabWindows::SlabWindows(const FrameGeometry& g, int finer)
    : slices(g.slices),
      between_slices(windows_of_slab(g, 0, 1, finer)),
      before_first(windows_of_slab(g, 0.5, 0, finer)),
      after_last(windows_of_slab(g, 0, 0.5, finer)) {}

BlockWindows::BlockWindows(const FrameGeometry& g, double around, double slices_before, double slices_after,
                           int finer)
    : from_eye_(g.view.eye.has_value()) {
  const auto [u, v] = in_plane(g.traversal.axis);
  const glm::dvec3 origin = homogeneous(g.view, glm::dvec3(0.0));
  const auto step = [&](int axis) {
    glm::dvec3 next(0.0);
    next[axis] = 1;
    return homogeneous(g.view, next) - origin;
  };
  const glm::dvec3 along_u = step(u), along_v = step(v), along_k = step(static_cast<int>(g.traversal.axis));
  const double voxel = 1.0 / finer, side = CellRanges::side * voxel, middle = 0.5 * (side - voxel),
               first = 0.5 * (side - 1);
  first_ = origin + first * (along_u + along_v) + 0.5 * (slices_after - slices_before) * along_k;
  column_ = side * along_u;
  row_ = side * along_v;
  slice_ = along_k;
  // Positions and rays are rounded to 2^-10 voxels or less.
  constexpr double rounding = 1.0 / 512;
  const double in_plane = middle + around * voxel + rounding,
               across = 0.5 * (slices_before + slices_after) + rounding;
  reach_[0] = in_plane * along_u;
  reach_[1] = in_plane * along_v;
  reach_[2] = across * along_k;
  half_ = glm::abs(glm::dvec2(reach_[0])) + glm::abs(glm::dvec2(reach_[1])) + glm::abs(glm::dvec2(reach_[2]));
}

PixelWindow BlockWindows::of(int column, int row, int slice) const {
  const glm::dvec3 centre = first_ + double(column) * column_ + double(row) * row_ + double(slice) * slice_;
  if (from_eye_) return seen_from_eye(centre);
  // A pixel's ray goes through its centre, half a pixel behind its number.
  return {floored(centre.x - half_.x - 0.5), floored(centre.y - half_.y - 0.5),
          floored(centre.x + half_.x + 0.5), floored(centre.y + half_.y + 0.5)};
}

PixelRect BlockWindows::blocks_in(const PixelWindow& pixels, int slice, int columns, int rows) const {
  const PixelRect all{0, 0, columns, rows};
  glm::dvec2 low(everywhere), high(-everywhere);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec2 pixel((corner & 1) != 0 ? pixels.x1 + 2 : pixels.x0 - 1,
                           (corner & 2) != 0 ? pixels.y1 + 2 : pixels.y0 - 1);
    // The place in the slice, or in the planes before and after it, whose block has its centre there.
    const glm::dvec3 first = first_ + double(slice) * slice_ + ((corner & 4) != 0 ? reach_[2] : -reach_[2]);
    const glm::dvec2 along_columns = glm::dvec2(column_) - pixel * column_.z,
                     along_rows = glm::dvec2(row_) - pixel * row_.z, to = pixel * first.z - glm::dvec2(first);
    const glm::dvec2 block = glm::inverse(glm::dmat2(along_columns, along_rows)) * to;
    // From an eye that looks along the slice there is no such place, or one behind the eye.
    if (!(glm::length(block) < everywhere) || !(first.z + block.x * column_.z + block.y * row_.z > 0))
      return all;
    low = glm::min(low, block);
    high = glm::max(high, block);
  }
  const glm::dvec2 around(1 + glm::length(reach_[0]) / glm::length(column_),
                          1 + glm::length(reach_[1]) / glm::length(row_));
  low = glm::clamp(glm::floor(low - around), glm::dvec2(0), glm::dvec2(columns, rows));
  high = glm::clamp(glm::ceil(high + around), glm::dvec2(0), glm::dvec2(columns, rows));
  return {int(low.x), int(low.y), int(high.x), int(high.y)};
}

PixelWindow BlockWindows::seen_from_eye(const glm::dvec3& centre) const {
  const double least_depth = 1e-9 * (std::abs(centre.z) + std::abs(reach_[0].z));
  glm::dvec2 low(everywhere), high(-everywhere);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p = centre + ((corner & 1) != 0 ? reach_[0] : -reach_[0]) +
                         ((corner & 2) != 0 ? reach_[1] : -reach_[1]) +
                         ((corner & 4) != 0 ? reach_[2] : -reach_[2]);
    // What reaches beside or behind the eye may be seen anywhere.
    if (!(p.z > least_depth))
      return {floored(-everywhere), floored(-everywhere), floored(everywhere), floored(everywhere)};
    const glm::dvec2 place = glm::dvec2(p) / p.z;
    low = glm::min(low, place);
    high = glm::max(high, place);
  }
  return {floored(low.x - 0.5), floored(low.y - 0.5), floored(high.x + 0.5), floored(high.y + 0.5)};
}

}  // namespace ringsplat
