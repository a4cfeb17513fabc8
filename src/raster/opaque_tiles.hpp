#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "ringsplat/base/bytes.hpp"

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

/// Tells how much of a rectangle of a region's pixels is under opaque tiles, in four look-ups without a loop:
/// it keeps the number of opaque tiles above and to the left of every tile's corner (summed areas, Crow
/// 1984).
class OpaqueCover {
 public:
  enum class Cover { none, some, all };

  void update(const OpaqueTiles& tiles) {
    opaque_ = tiles.opaque();
    worth_asking_ = tiles.worth_asking();
    width_ = tiles.columns() * OpaqueTiles::tile_size;
    height_ = tiles.rows() * OpaqueTiles::tile_size;
    stride_ = std::size_t(tiles.columns()) + 1;
    sums_.assign(stride_ * (std::size_t(tiles.rows()) + 1), 0);
    for (int row = 0; row < tiles.rows(); ++row) {
      std::int32_t* sum = sums_.data() + (std::size_t(row) + 1) * stride_;
      std::int32_t in_row = 0;
      for (int column = 0; column < tiles.columns(); ++column) {
        in_row += tiles.is_opaque(column, row);
        sum[column + 1] = sum[std::ptrdiff_t(column) + 1 - std::ptrdiff_t(stride_)] + in_row;
      }
    }
  }
  int opaque() const { return opaque_; }
  bool worth_asking() const { return worth_asking_; }

  /// How many of the region's tiles under pixels x0 … x1, y0 … y1 are opaque. Pixels count from the region's
  /// corner, x0 ≤ x1 and y0 ≤ y1; none when they are wholly outside.
  Cover of(double x0, double y0, double x1, double y1) const {
    if (!(x1 >= 0 && y1 >= 0 && x0 < width_ && y0 < height_)) return Cover::none;
    const std::size_t left = tile(x0, width_), right = tile(x1, width_) + 1, top = tile(y0, height_),
                      bottom = tile(y1, height_) + 1;
    const std::int32_t count = sums_[bottom * stride_ + right] - sums_[top * stride_ + right] -
                               sums_[bottom * stride_ + left] + sums_[top * stride_ + left];
    if (count == 0) return Cover::none;
    return std::size_t(count) == (right - left) * (bottom - top) ? Cover::all : Cover::some;
  }

 private:
  static std::size_t tile(double pixel, int size) {
    return std::size_t(static_cast<std::int32_t>(std::clamp(pixel, 0.0, double(size) - 1))) /
           OpaqueTiles::tile_size;
  }

  int opaque_ = 0;              ///< tiles
  int width_ = 0, height_ = 0;  ///< of all tiles, in pixels
  bool worth_asking_ = false;
  std::size_t stride_ = 0;
  std::vector<std::int32_t> sums_;
};

/// Appends one region's opaque tiles as they travel: the region's number, then a bit for each tile, row by
/// row.
void append_opaque_news(int region, const OpaqueTiles& tiles, Bytes& news);

/// Adds the news of any number of regions to `known`, which is indexed by region. Throws RunError when the
/// bytes name no region or end too early.
void read_opaque_news(std::span<const std::byte> news, std::vector<OpaqueTiles>& known);

}  // namespace ringsplat
