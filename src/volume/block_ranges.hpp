#pragma once
#include <cstddef>
#include <vector>

#include "volume/slice_store.hpp"

namespace ringsplat {

/// The smallest and the largest value of each block of a slice's voxels. With them transparent blocks are
/// skipped without being read (Levoy 1990, in the plane). Not-a-number is ignored. Stores 2 scalars for a
/// block's 128.
class BlockRanges {
 public:
  static constexpr int block_width = 16,
                       block_height = 8;  ///< voxels; those at the end of a row or column may be smaller

  struct Range {
    double low, high;  ///< low > high: the whole block is not-a-number
  };

  explicit BlockRanges(const SliceView& slice);
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Range range(int column, int row) const;

 private:
  ScalarType type_;
  int columns_, rows_;
  std::vector<std::byte> ranges_;  ///< low and high of each block in the slice's scalar type, row by row
};

}  // namespace ringsplat
