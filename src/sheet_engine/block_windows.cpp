#include "sheet_engine/block_windows.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "volume/cell_ranges.hpp"

namespace ringsplat {

BlockWindows::BlockWindows(const FrameGeometry& g, double around, double slices_before, double slices_after) {
  const auto [u, v] = in_plane(g.traversal.axis);
  const glm::dvec2 along_u(g.view.linear[u]), along_v(g.view.linear[v]),
      along_k(g.view.linear[static_cast<int>(g.traversal.axis)]);
  constexpr double side = CellRanges::side, middle = 0.5 * (side - 1);
  first_ = glm::dvec2(g.view.offset) + middle * (along_u + along_v) +
           0.5 * (slices_after - slices_before) * along_k;
  column_ = side * along_u;
  row_ = side * along_v;
  slice_ = along_k;
  // Positions and rays are rounded to 2^-16 voxels.
  constexpr double rounding = 1.0 / 1024;
  half_ = (middle + around + rounding) * (glm::abs(along_u) + glm::abs(along_v)) +
          (0.5 * (slices_before + slices_after) + rounding) * glm::abs(along_k);
}

PixelWindow BlockWindows::of(int column, int row, int slice) const {
  const glm::dvec2 centre = first_ + double(column) * column_ + double(row) * row_ + double(slice) * slice_;
  // A pixel's ray goes through its centre, half a pixel behind its number.
  const auto floored = [](double x) { return std::int64_t(std::floor(std::clamp(x, -1e9, 1e9))); };
  return {floored(centre.x - half_.x - 0.5), floored(centre.y - half_.y - 0.5),
          floored(centre.x + half_.x + 0.5), floored(centre.y + half_.y + 0.5)};
}

}  // namespace ringsplat
