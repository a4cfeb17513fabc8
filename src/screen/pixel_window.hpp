#pragma once
#include <algorithm>
#include <cstdint>

namespace ringsplat {

/// Inclusive block of screen pixels.
struct PixelWindow {
  std::int64_t x0, y0, x1, y1;
};
/// The smallest with both.
inline PixelWindow hull(const PixelWindow& a, const PixelWindow& b) {
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

}  // namespace ringsplat
