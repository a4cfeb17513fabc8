#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace ringsplat {

/// Half-open rectangle of pixels: x0 … x1 − 1, y0 … y1 − 1.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool operator==(const PixelRect&) const = default;
};

/// The pixels of the image plane from (x0, y0) to (x1, y1), both included: unlike a PixelRect, whose end is
/// not.
struct PixelWindow {
  std::int64_t x0, y0, x1, y1;
};
/// The smallest window with both.
inline PixelWindow hull(const PixelWindow& a, const PixelWindow& b) {
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

/// In place of a Renderer: the region is no one's.
inline constexpr int nobody = -1;

/// The image plane cut into regions of one size, numbered row by row. Those at the right and lower edge may
/// be smaller.
class Regions {
 public:
  Regions() = default;
  /// Squares. Throws InputError when a size is below 1 or the picture has more than 2^31 - 1 regions or
  /// pixels a side over 2^20.
  Regions(int width, int height, int region_size) : Regions(width, height, region_size, region_size) {}
  /// Rectangles; throws likewise.
  Regions(int width, int height, int region_width, int region_height);
  bool operator==(const Regions&) const = default;
  int count() const { return columns_ * rows_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// The region's pixels.
  PixelRect rect(int region) const {
    const int x0 = region % columns_ * region_width_, y0 = region / columns_ * region_height_;
    // Sizes near 2^31 are allowed, so the far corner is found from what is left: x0 + size may overflow.
    return {x0, y0, x0 + std::min(region_width_, width_ - x0), y0 + std::min(region_height_, height_ - y0)};
  }

  /// The regions that these pixels touch, in columns and rows of regions. Clipped to the image plane; empty
  /// when outside it.
  PixelRect touched(const PixelWindow& pixels) const;

 private:
  int width_ = 0, height_ = 0, region_width_ = 1, region_height_ = 1, columns_ = 0, rows_ = 0;
};

}  // namespace ringsplat
