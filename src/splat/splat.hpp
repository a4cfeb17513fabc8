#pragma once
#include <cstdint>

#include "splat/footprint.hpp"

namespace ringsplat {

/// One voxel's kernel in six 32-bit words.
///
/// The evaluator's origin is offset to the splat's own anchor, the pixel at or below its centre, rather
/// than to the region's corner as in Neumann 1992 (section 2.2): float32 coefficients then lose nothing
/// however large the region or the image, and a splat has the same bits in every region it reaches.
struct Splat {
  /// Q = a dx + b dy + c + D dx² + E dx dy + F dy², with (dx, dy) in pixels from the anchor's centre.
  float a, b, c;
  float opacity;                    ///< corrected opacity × Footprint::weight
  std::uint16_t red, green, blue;   ///< straight linear colour, 65535 = 1; premultiplied when drawn
  std::uint8_t anchor_x, anchor_y;  ///< anchor pixel − the group's base
};
static_assert(sizeof(Splat) == 24);

/// Coefficients larger than this come from no footprint: every semi-axis is at least a pixel. Such splats,
/// and those with NaN, are counted as clipped, so that no bytes from outside can put an infinity or a NaN
/// into the picture.
inline constexpr float largest_coefficient = 1e6F;

/// Heads a run of splats of one region whose anchors lie within 256 × 256 pixels from its base.
struct SplatGroup {
  std::int32_t region;
  std::int32_t base_x, base_y;  ///< pixel of the image plane, inside the image or not
  std::uint32_t count;          ///< splats that follow
};
static_assert(sizeof(SplatGroup) == 16);

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

}  // namespace ringsplat
