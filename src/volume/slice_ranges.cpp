#include "volume/slice_ranges.hpp"

#include <algorithm>

#include "volume/value_ends.hpp"

namespace ringsplat {

SliceRange slice_range(const SliceView& slice) {
  return visit_type(slice.type, [&](auto zero) {
    auto ends = no_values<decltype(zero)>();
    widen(ends, slice.values, std::size_t(slice.width) * std::size_t(slice.height));
    return SliceRange{slice.axis, slice.index, static_cast<double>(ends.low), static_cast<double>(ends.high)};
  });
}

SliceRanges::SliceRanges(const std::vector<SliceRange>& ranges) {
  for (const SliceRange& range : ranges) ranges_[std::size_t(range.axis)].push_back(range);
  for (auto& axis : ranges_)
    std::sort(axis.begin(), axis.end(),
              [](const SliceRange& a, const SliceRange& b) { return a.slice < b.slice; });
}

}  // namespace ringsplat
