#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "volume/cell_ranges.hpp"

namespace ringsplat {

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
