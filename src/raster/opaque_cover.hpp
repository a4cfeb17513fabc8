#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "raster/opaque_tiles.hpp"

namespace ringsplat {

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

}  // namespace ringsplat
