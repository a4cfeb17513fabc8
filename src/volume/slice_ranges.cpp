#include "ringsplat/volume/slice_ranges.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

namespace ringsplat {

SliceRange slice_range(const SliceView& slice) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  SliceRange range{slice.axis, slice.index, infinity, -infinity};
  visit_type(slice.type, [&](auto zero) {
    using T = decltype(zero);
    using Limits = std::numeric_limits<T>;
    T low = Limits::has_infinity ? Limits::infinity() : Limits::max(),
      high = Limits::has_infinity ? -Limits::infinity() : Limits::lowest();
    const std::size_t voxels = std::size_t(slice.width) * std::size_t(slice.height);
    bool any = !Limits::has_infinity && voxels > 0;
    for (std::size_t k = 0; k < voxels; ++k) {
      T value;
      std::memcpy(&value, slice.values + k * sizeof(T), sizeof(T));
      // A comparison with not-a-number is false and keeps the end.
      low = value < low ? value : low;
      high = value > high ? value : high;
      any |= value == value;
    }
    if (any) range = {slice.axis, slice.index, static_cast<double>(low), static_cast<double>(high)};
  });
  return range;
}

SliceRanges::SliceRanges(const std::vector<SliceRange>& ranges) {
  for (const SliceRange& range : ranges) ranges_[std::size_t(range.axis)].push_back(range);
  for (auto& axis : ranges_)
    std::sort(axis.begin(), axis.end(),
              [](const SliceRange& a, const SliceRange& b) { return a.slice < b.slice; });
}

}  // namespace ringsplat
