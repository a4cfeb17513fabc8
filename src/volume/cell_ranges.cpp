#include "volume/cell_ranges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "volume/value_ends.hpp"

namespace ringsplat {

CellRanges::CellRanges(const SliceView& slice)
    : columns_(blocks_along(slice.width)), rows_(blocks_along(slice.height)) {
  visit_type(slice.type, [&](auto zero) {
    using T = decltype(zero);
    std::vector<ValueEnds<T>> ends(std::size_t(columns_) * std::size_t(rows_), no_values<T>());
    std::vector<ValueEnds<T>> of_row(static_cast<std::size_t>(columns_));
    for (int y = 0; y < slice.height; ++y) {
      const std::byte* row = slice.values_of_row(y);
      for (int column = 0; column < columns_; ++column) {
        const int first = column * side;
        ValueEnds<T> here = no_values<T>();
        widen(here, row + std::size_t(first) * sizeof(T),
              std::size_t(std::min(side + 1, slice.width - first)));
        of_row[std::size_t(column)] = here;
      }
      const auto widen_blocks = [&](int block_row) {
        for (int column = 0; column < columns_; ++column) {
          auto& block = ends[std::size_t(block_row) * std::size_t(columns_) + std::size_t(column)];
          const auto& here = of_row[std::size_t(column)];
          block.low = std::min(block.low, here.low);
          block.high = std::max(block.high, here.high);
        }
      };
      widen_blocks(y / side);
      if (y % side == 0 && y > 0) widen_blocks(y / side - 1);
    }
    ends_ = BlockEnds(slice.type, ends);
  });
}

CellRanges::CellRanges(ScalarType type, int width, int height, std::span<const std::byte> bytes)
    : columns_(blocks_along(width)), rows_(blocks_along(height)), ends_(type, bytes) {
  if (bytes.size() != std::size_t(columns_) * std::size_t(rows_) * 2 * size_of(type))
    throw RunError(
        fmt::format("a rank sent {} bytes as the ranges of {} x {} blocks", bytes.size(), columns_, rows_),
        "all ranks must run the same build");
}

}  // namespace ringsplat
