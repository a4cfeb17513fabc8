#pragma once
#include <algorithm>
#include <cstdint>
#include <utility>
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

/// Which Renderer owns a region: the one map from regions to Renderers, used by all. Either what each costs
/// is known, and a list says who gets which (frame/work_estimate.hpp), or they are dealt in turn:
///
/// Only a rectangle of regions is dealt, those that a frame's volume reaches; nobody owns the others. The
/// region in the rectangle's column x and row y belongs to Renderer x + skew · y, modulo their number, so
/// that all have equally many regions or one fewer. Among the skews that keep this, the constructor takes the
/// one with the longest way from a region to the nearest one of the same Renderer (the lattices of Korobov
/// 1959), which deals neighbouring regions to many Renderers. Dealing in turn would be a skew of the row's
/// length and give a Renderer whole columns when the two numbers have a common divisor. In Neumann 1992
/// (section 3) a Renderer has one region.
class RegionOwners {
 public:
  static constexpr int nobody = -1;
  /// `columns`: of all regions. `block`: the regions to deal, in columns and rows of regions. `dealt_to`: how
  /// many of the Renderers get any, spread evenly among them.
  RegionOwners(int columns, const PixelRect& block, int renderers, int dealt_to);
  RegionOwners() = default;
  bool operator==(const RegionOwners&) const = default;
  /// Dealt otherwise: by region, its Renderer or nobody.
  explicit RegionOwners(std::vector<int> dealt) : dealt_(std::move(dealt)) {}
  int of(int region) const {
    if (!dealt_.empty()) return dealt_[std::size_t(region)];
    const int column = static_cast<int>(region % columns_), row = static_cast<int>(region / columns_);
    if (column < block_.x0 || column >= block_.x1 || row < block_.y0 || row >= block_.y1) return nobody;
    return static_cast<int>((column - block_.x0 + (row - block_.y0) * skew_) % dealt_to_ * renderers_ /
                            dealt_to_);
  }

 private:
  std::int64_t columns_ = 1, renderers_ = 1, dealt_to_ = 1, skew_ = 0;
  PixelRect block_;
  std::vector<int> dealt_;
};

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
  PixelRect rect(int region) const;

  RegionOwners owners(const PixelRect& block, int renderers, int dealt_to) const {
    return {columns_, block, renderers, dealt_to};
  }
  std::vector<int> owned(int renderer, const RegionOwners& owners) const;

  /// The regions that these pixels touch, in columns and rows of regions. Clipped to the image plane; empty
  /// when outside it.
  PixelRect touched(const PixelWindow& pixels) const;

 private:
  int width_ = 0, height_ = 0, region_width_ = 1, region_height_ = 1, columns_ = 0, rows_ = 0;
};

}  // namespace ringsplat
