#pragma once
#include <cstdint>

#include "raster/slice_buffer.hpp"
#include "screen/regions.hpp"
#include "splat/footprint.hpp"

namespace ringsplat {

/// One voxel's kernel.
///
/// The evaluator's origin is offset to the splat's own anchor, the pixel at or below its centre, rather
/// than to the region's corner as in Neumann 1992 (section 2.2): float32 coefficients then lose nothing
/// however large the region or the image, and a splat has the same bits in every region it reaches.
struct Splat {
  /// Q = a dx + b dy + c + D dx² + E dx dy + F dy², with (dx, dy) in pixels from the anchor's centre.
  float a, b, c;
  float opacity;                    ///< corrected opacity × Footprint::weight
  std::uint16_t red, green, blue;   ///< straight linear colour, 65535 = 1; premultiplied when drawn
  std::int64_t anchor_x, anchor_y;  ///< anchor's pixel in the image plane
};

/// Coefficients larger than this come from no footprint: every semi-axis is at least a pixel. Such splats,
/// and those with NaN, are counted as clipped, so that no opacity from outside can put an infinity or a NaN
/// into the picture.
inline constexpr float largest_coefficient = 1e6F;

struct DrawCounts {
  std::uint64_t drawn = 0;    ///< splats that reached at least one pixel centre of the region with Q > 0
  std::uint64_t clipped = 0;  ///< splats that reached none
  std::uint64_t hidden = 0;   ///< splats that lie wholly under opaque tiles, not drawn
};

/// A voxel's place in the image plane: its anchor pixel, and the offset of its centre from the anchor's
/// centre, in [0, 1]. (1 itself only when the subtraction rounds up to it.)
struct Anchored {
  std::int64_t anchor_x, anchor_y;
  double dx, dy;
};

/// The last pixel whose centre (integer + ½) is at or before `position`. Positions beyond ±2^40 pixels, and
/// NaN, give the pixel at that edge.
inline std::int64_t anchor_pixel(double position) {
  constexpr double edge = 1099511627776.0;
  // A comparison with NaN is false, so that the conversion below is defined for every argument.
  const double shifted = position > -edge ? (position < edge ? position - 0.5 : edge) : -edge;
  const auto truncated = static_cast<std::int64_t>(shifted);
  return truncated - static_cast<std::int64_t>(static_cast<double>(truncated) > shifted);
}

inline Anchored anchor(double x, double y) {
  const auto ax = anchor_pixel(x), ay = anchor_pixel(y);
  return {ax, ay, x - 0.5 - static_cast<double>(ax), y - 0.5 - static_cast<double>(ay)};
}

/// How far a frame's kernels reach from their anchor, the pixel at or before the centre: only the pixels
/// anchor − reach … anchor + reach + 1 can have Q > 0.
struct KernelReach {
  std::int64_t x, y;  ///< whole pixels before the anchor; one more after it
};
inline KernelReach kernel_reach(const Footprint& footprint) {
  return {static_cast<std::int64_t>(footprint.half.x), static_cast<std::int64_t>(footprint.half.y)};
}

/// A window meets a region when its anchor is at most reach + 1 before it or reach behind it, and starts
/// reach before its anchor. On both sides there is also the rest of a pixel block.
inline Margins window_margins(KernelReach reach) {
  const std::ptrdiff_t x = 2 * reach.x + 1, y = 2 * reach.y + 1;
  return {x + block_pixels, x + block_pixels, y, y};
}
inline PixelWindow pixel_window(const Anchored& at, KernelReach reach) {
  return {at.anchor_x - reach.x, at.anchor_y - reach.y, at.anchor_x + reach.x + 1, at.anchor_y + reach.y + 1};
}

/// A voxel's straight linear colour, 65535 = 1, and its opacity, corrected for the slice distance.
struct VoxelColour {
  std::uint16_t red, green, blue;
  float opacity;
};

/// Coefficients are computed in double precision and rounded once.
inline Splat make_splat(const Footprint& footprint, const Anchored& at, const VoxelColour& colour) {
  const auto q = coefficients(footprint, at.dx, at.dy);
  return {static_cast<float>(q.a),
          static_cast<float>(q.b),
          static_cast<float>(q.c),
          static_cast<float>(static_cast<double>(colour.opacity) * footprint.weight),
          colour.red,
          colour.green,
          colour.blue,
          at.anchor_x,
          at.anchor_y};
}

}  // namespace ringsplat
