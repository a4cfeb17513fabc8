#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace ringsplat {

/// Which tiles of a region are opaque: squares of 16 × 16 pixels from the region's corner on, of which those
/// at its right and lower edge may be smaller. In the course of a frame tiles become opaque and stay so.
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
  int opaque() const { return count_; }  ///< number of opaque tiles
  /// False while so few tiles are opaque that asking about every splat takes longer than drawing what they
  /// hide.
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

  /// Whether opaque tiles hide all of these pixels that lie inside the region. Pixels count from the region's
  /// corner, x1 and y1 included; a window wholly outside is not hidden.
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
