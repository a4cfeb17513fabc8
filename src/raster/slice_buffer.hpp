#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace ringsplat {

/// Inclusive run of pixels in a row; empty when first > last.
struct Run {
  std::int32_t first = std::numeric_limits<std::int32_t>::max();
  std::int32_t last = std::numeric_limits<std::int32_t>::min();
  void include(std::int32_t a, std::int32_t b) {
    first = std::min(first, a);
    last = std::max(last, b);
  }
  bool empty() const { return first > last; }
};

/// A region's slice buffer as the vector code sees it.
///
/// Pixels are four floats (premultiplied red, green, blue, opacity), so a vector adds whole pixels: four
/// float planes would take four read-modify-writes for every run of pixels instead of one.
struct SliceBuffer {
  float* origin = nullptr;  ///< pixel (0, 0) of the region; 64-byte aligned, as is every row's first pixel
  std::ptrdiff_t row_floats = 0;  ///< floats from a row to the next
  int width = 0, height = 0;      ///< pixels of the region, without the margins
  /// Stencil path: [height + 2 reach_y + 1], the anchors' columns, by anchor row from −reach_y − 1. Row path:
  /// [height], pixels written.
  Run* runs = nullptr;
  bool holds(int x, int y) const { return x >= 0 && x < width && y >= 0 && y < height; }
};

}  // namespace ringsplat
