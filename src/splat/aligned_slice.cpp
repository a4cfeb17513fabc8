#include "splat/aligned_slice.hpp"

#include <cmath>

#include "splat/splat_sum.hpp"

namespace ringsplat {
namespace {

/// The weights of the pixels in a kernel's window, row by row, for a voxel that lies so far from its anchor.
std::vector<float> window_weights(const Footprint& footprint, KernelReach reach, double dx, double dy) {
  const auto exact = coefficients(footprint, dx, dy);
  const auto a = float(exact.a), b = float(exact.b), c = float(exact.c);
  std::vector<float> weights;
  for (int y = -int(reach.y); y <= reach.y + 1; ++y)
    for (int x = -int(reach.x); x <= reach.x + 1; ++x) {
      const float q = std::fma(a, float(x), quadratic_part(footprint, x, y)) + std::fma(b, float(y), c);
      weights.push_back(q > 0 ? q * q : 0.0F);
    }
  return weights;
}

void take_weights(const std::vector<float>& window, AlignedSlice& slice) {
  const int width = 2 * slice.reach_x + 2, height = 2 * slice.reach_y + 2;
  const auto weight = [&](int row, int column) {
    return column < width ? window[std::size_t(row) * std::size_t(width) + std::size_t(column)] : 0.0F;
  };
  slice.covered.reserve(window.size());
  slice.first_column = width;
  slice.first_row = height;
  slice.end_column = slice.end_row = 0;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      if (!(weight(row, column) > 0)) continue;
      slice.covered.emplace_back(column - slice.reach_x, row - slice.reach_y);
      slice.first_column = std::min(slice.first_column, column);
      slice.end_column = std::max(slice.end_column, column + 1);
      slice.first_row = std::min(slice.first_row, row);
      slice.end_row = row + 1;
    }
  // How many steps the window's first column is from the rightmost and from the leftmost voxel that reaches
  // it. Both exist: no kernel is so narrow that it lies between pixels (narrowest_half_width).
  const int least = slice.first_column / slice.step_x, most = (slice.end_column - 1) / slice.step_x;
  slice.taps = most - least + 1;
  slice.first_tap_x = slice.reach_x - most * slice.step_x;
  slice.weights.reserve(std::size_t(height) * std::size_t(slice.taps) * tap_floats);
  for (int row = 0; row < height; ++row)
    for (int tap = 0; tap < slice.taps; ++tap)
      for (int pixel = 0; pixel < tap_floats / 4; ++pixel) {
        const int column = pixel % slice.step_x + (most - tap) * slice.step_x;
        slice.weights.insert(slice.weights.end(), 4, weight(row, column));
      }
}

}  // namespace

std::optional<AlignedFrame> AlignedFrame::of(const Footprint& footprint, const ViewTransform& view,
                                             Axis axis) {
  const auto is_whole = [](double step) { return step == 1 || step == 2 || step == largest_step; };
  const auto [u, v] = in_plane(axis);
  const glm::dvec2 along_u(view.linear[u]), along_v(view.linear[v]);
  if (along_u.y != 0 || along_v.x != 0 || !is_whole(along_u.x) || !is_whole(along_v.y)) return {};
  if (!has_stencil(footprint)) return {};
  return AlignedFrame{footprint, view, axis, glm::ivec2(int(along_u.x), int(along_v.y))};
}

AlignedSlice AlignedFrame::slice(int index) const {
  glm::dvec3 first(0.0);
  first[int(axis)] = index;
  const glm::dvec3 position = view.project(first);
  const Anchored at = anchor(position.x, position.y);
  const KernelReach reach = kernel_reach(footprint);
  AlignedSlice slice{.step_x = steps.x,
                     .step_y = steps.y,
                     .anchor_x = at.anchor_x,
                     .anchor_y = at.anchor_y,
                     .reach_x = int(reach.x),
                     .reach_y = int(reach.y),
                     .opacity_weight = footprint.weight};
  take_weights(window_weights(footprint, reach, at.dx, at.dy), slice);
  return slice;
}

}  // namespace ringsplat
