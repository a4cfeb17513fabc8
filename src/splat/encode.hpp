#pragma once
#include <algorithm>
#include <cstdint>

#include "raster/slice_buffer.hpp"
#include "screen/pixel_window.hpp"
#include "splat/splat.hpp"

namespace ringsplat {

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

/// [0, 1] to [0, 65535], rounded to nearest; values outside, and NaN, go to the nearer end or 0.
inline std::uint16_t quantise_colour(float value) {
  // The value is not negative, so adding a half and truncating rounds; lround would be a call.
  const float inside = std::min(std::max(0.0F, value), 1.0F);
  return static_cast<std::uint16_t>(
      static_cast<std::int32_t>(inside * 65535.0F + 0.5F));  // NOLINT(bugprone-incorrect-roundings)
}

/// A splat's opacity word: the corrected opacity times the kernel's weight.
inline float weighted_opacity(const Footprint& footprint, float opacity) {
  return static_cast<float>(static_cast<double>(opacity) * footprint.weight);
}

/// One voxel's six words. (dx, dy) is Anchored's offset; the colour is straight and linear; `opacity` is
/// corrected for the slice distance and not yet weighted. anchor_x and anchor_y count from the base of the
/// group the splat goes to. Coefficients are computed in double precision and rounded once.
inline Splat make_splat(const Footprint& footprint, double dx, double dy, float red, float green, float blue,
                        float opacity, std::uint8_t anchor_x = 0, std::uint8_t anchor_y = 0) {
  const auto q = coefficients(footprint, dx, dy);
  return {static_cast<float>(q.a),
          static_cast<float>(q.b),
          static_cast<float>(q.c),
          weighted_opacity(footprint, opacity),
          quantise_colour(red),
          quantise_colour(green),
          quantise_colour(blue),
          anchor_x,
          anchor_y};
}

}  // namespace ringsplat
