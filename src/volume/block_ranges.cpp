#include "volume/block_ranges.hpp"

#include <algorithm>
#include <vector>

#include "volume/value_ends.hpp"

namespace ringsplat {

BlockRanges::BlockRanges(const SliceView& slice)
    : columns_((slice.width + block_width - 1) / block_width),
      rows_((slice.height + block_height - 1) / block_height) {
  visit_type(slice.type, [&](auto zero) {
    using T = decltype(zero);
    std::vector<ValueEnds<T>> ends(std::size_t(columns_) * std::size_t(rows_), no_values<T>());
    for (int y = 0; y < slice.height; ++y) {
      const std::byte* row = slice.values_of_row(y);
      for (int column = 0; column < columns_; ++column) {
        const int first = column * block_width;
        widen(ends[std::size_t(y / block_height) * std::size_t(columns_) + std::size_t(column)],
              row + std::size_t(first) * sizeof(T), std::size_t(std::min(block_width, slice.width - first)));
      }
    }
    ends_ = BlockEnds(slice.type, ends);
  });
}

}  // namespace ringsplat
