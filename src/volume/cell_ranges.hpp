#pragma once
#include <cstddef>
#include <span>

#include "volume/block_ends.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// The smallest and the largest value that interpolation within a block of a slice's cells can take: those of
/// its 8 x 8 voxels and of the row and column behind them. Not-a-number is ignored. Stores 2 scalars for a
/// block's 64.
class CellRanges {
 public:
  static constexpr int side = 8;  ///< voxels; blocks at the end of a row or column may be smaller

  using Range = BlockEnds::Range;

  explicit CellRanges(const SliceView& slice);
  /// From bytes() of a slice of the same size and type. Throws RunError when their number is another.
  CellRanges(ScalarType type, int width, int height, std::span<const std::byte> bytes);

  static int blocks_along(int voxels) { return (voxels + side - 1) / side; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Range range(int column, int row) const {
    return ends_.range(std::size_t(row) * std::size_t(columns_) + std::size_t(column));
  }
  /// For processes of one build.
  std::span<const std::byte> bytes() const { return ends_.bytes(); }

 private:
  int columns_, rows_;
  BlockEnds ends_;  ///< row by row
};

}  // namespace ringsplat
