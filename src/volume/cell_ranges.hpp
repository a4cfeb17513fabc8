#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "volume/slice_store.hpp"

namespace ringsplat {

/// The smallest and the largest value of each block of a slice, infinities included, in its scalar type.
/// Not-a-number is ignored.
class RangesOfBlocks {
 public:
  struct Range {
    double low, high;  ///< low > high: the whole block is not-a-number
  };

  /// In voxels; blocks at the end of a row or column may be smaller. The rows and columns up to `beyond`
  /// behind a block count, too.
  struct Shape {
    int width, height, beyond;
  };
  RangesOfBlocks(const SliceView& slice, const Shape& shape);
  /// From bytes() of such a slice.
  RangesOfBlocks(ScalarType type, int columns, int rows, std::span<const std::byte> bytes)
      : type_(type), columns_(columns), rows_(rows), ends_(bytes.begin(), bytes.end()) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Range range(int column, int row) const;
  /// For processes of one build.
  std::span<const std::byte> bytes() const { return ends_; }

 private:
  ScalarType type_;
  int columns_, rows_;
  std::vector<std::byte> ends_;  ///< of each block the smallest and the largest scalar, row by row
};

/// With them transparent blocks are skipped without being read (Levoy 1990, in the plane). Stores 2 scalars
/// for a block's 128.
class BlockRanges : public RangesOfBlocks {
 public:
  static constexpr int block_width = 16, block_height = 8;

  explicit BlockRanges(const SliceView& slice) : RangesOfBlocks(slice, {block_width, block_height, 0}) {}
};

/// What interpolation within a block of a slice's cells can give: the range of its 8 x 8 voxels and of the
/// row and column behind them. Stores 2 scalars for a block's 64.
class CellRanges : public RangesOfBlocks {
 public:
  static constexpr int side = 8;

  explicit CellRanges(const SliceView& slice) : RangesOfBlocks(slice, {side, side, 1}) {}
  /// From bytes() of a slice of the same size and type.
  CellRanges(ScalarType type, int width, int height, std::span<const std::byte> bytes)
      : RangesOfBlocks(type, blocks_along(width), blocks_along(height), bytes) {}

  static int blocks_along(int voxels) { return (voxels + side - 1) / side; }
};

inline SliceRange slice_range(const SliceView& slice) {
  const auto [low, high] = RangesOfBlocks(slice, {slice.width, slice.height, 0}).range(0, 0);
  return {slice.axis, slice.index, low, high};
}

}  // namespace ringsplat
