#pragma once
#include <cstddef>

#include "volume/block_ends.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// The smallest and the largest value of each block of a slice's voxels. With them transparent blocks are
/// skipped without being read (Levoy 1990, in the plane). Not-a-number is ignored. Stores 2 scalars for a
/// block's 128.
class BlockRanges {
 public:
  static constexpr int block_width = 16,
                       block_height = 8;  ///< voxels; those at the end of a row or column may be smaller

  using Range = BlockEnds::Range;

  explicit BlockRanges(const SliceView& slice);
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Range range(int column, int row) const {
    return ends_.range(std::size_t(row) * std::size_t(columns_) + std::size_t(column));
  }

 private:
  int columns_, rows_;
  BlockEnds ends_;  ///< row by row
};

}  // namespace ringsplat
