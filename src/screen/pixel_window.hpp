#pragma once
#include <algorithm>
#include <cstdint>

namespace ringsplat {

/// The pixels of the image plane from (x0, y0) to (x1, y1), both included: unlike a PixelRect, whose end is
/// not.
struct PixelWindow {
  std::int64_t x0, y0, x1, y1;
};
/// The smallest window with both.
inline PixelWindow hull(const PixelWindow& a, const PixelWindow& b) {
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

}  // namespace ringsplat
