#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace ringsplat {

/// Which 16 × 16 pixel tiles of a region are opaque, counted from the region's corner; those at its right and
/// lower edge may be smaller. Tiles only become opaque in the course of a frame, never transparent again.
class OpaqueTiles {
 public:
  static constexpr int tile_size = 16;  ///< pixels

  OpaqueTiles() = default;
  OpaqueTiles(int width, int height)
      : columns_((width + tile_size - 1) / tile_size),
        rows_((height + tile_size - 1) / tile_size),
        opaque_(std::size_t(columns_) * std::size_t(rows_), 0) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int opaque() const { return count_; }  ///< how many are
  /// False while so few are opaque that asking for every splat takes longer than drawing what they hide.
  bool worth_asking() const { return count_ > 0 && 8 * count_ >= columns_ * rows_; }
  bool is_opaque(int column, int row) const { return opaque_[at(column, row)] != 0; }
  void set_opaque(int column, int row) {
    count_ += opaque_[at(column, row)] == 0;
    opaque_[at(column, row)] = 1;
  }
  void clear() {
    std::fill(opaque_.begin(), opaque_.end(), std::uint8_t{0});
    count_ = 0;
  }

  /// True when the part of these pixels (inclusive, from the region's corner) inside the region is under
  /// opaque tiles; pixels wholly outside are not hidden.
  bool hides(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) const {
    if (count_ == 0) return false;
    const std::int64_t left = std::max<std::int64_t>(x0 >> shift, 0),
                       right = std::min<std::int64_t>(x1 >> shift, columns_ - 1);
    const std::int64_t top = std::max<std::int64_t>(y0 >> shift, 0),
                       bottom = std::min<std::int64_t>(y1 >> shift, rows_ - 1);
    if (left > right || top > bottom) return false;
    for (std::int64_t y = top; y <= bottom; ++y)
      for (std::int64_t x = left; x <= right; ++x)
        if (!is_opaque(int(x), int(y))) return false;
    return true;
  }

 private:
  static constexpr int shift = 4;
  static_assert(tile_size == 1 << shift);
  std::size_t at(int column, int row) const {
    return std::size_t(row) * std::size_t(columns_) + std::size_t(column);
  }

  int columns_ = 0, rows_ = 0, count_ = 0;
  std::vector<std::uint8_t> opaque_;
};

}  // namespace ringsplat
