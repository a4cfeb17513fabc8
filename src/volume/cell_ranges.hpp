#pragma once
#include <algorithm>
#include <array>
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

/// The smallest and the largest value of a slice, infinities included. Not-a-number is ignored; low > high
/// when the slice has nothing else.
struct SliceRange {
  Axis axis = Axis::z;
  int slice = 0;
  double low = 0, high = 0;
};
inline SliceRange slice_range(const SliceView& slice) {
  const auto [low, high] = RangesOfBlocks(slice, {slice.width, slice.height, 0}).range(0, 0);
  return {slice.axis, slice.index, low, high};
}

/// The ranges of all slices of a volume, other GPs' too, so that every GP knows which slices a transfer
/// function makes transparent.
class SliceRanges {
 public:
  /// `ranges`: in any order; for each axis all slices or none.
  explicit SliceRanges(const std::vector<SliceRange>& ranges) {
    for (const SliceRange& range : ranges) ranges_[std::size_t(range.axis)].push_back(range);
    for (auto& axis : ranges_)
      std::sort(axis.begin(), axis.end(),
                [](const SliceRange& a, const SliceRange& b) { return a.slice < b.slice; });
  }
  /// The ranges of an axis, by slice; may be empty.
  const std::vector<SliceRange>& of(Axis axis) const { return ranges_[std::size_t(axis)]; }

 private:
  std::array<std::vector<SliceRange>, 3> ranges_;
};

}  // namespace ringsplat
