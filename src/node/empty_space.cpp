#include "node/empty_space.hpp"

#include <algorithm>

namespace ringsplat {

SliceRuns::SliceRuns(const BlockRanges& ranges, const TransferFunction& transfer_function, int width) {
  begin_.push_back(0);
  for (int row = 0; row < ranges.rows(); ++row) {
    for (int column = 0; column < ranges.columns(); ++column) {
      const auto [low, high] = ranges.range(column, row);
      if (!(low <= high) || !transfer_function.visible_within(low, high)) continue;
      const int first = column * BlockRanges::block_width,
                end = std::min(first + BlockRanges::block_width, width);
      if (runs_.size() > begin_.back() && runs_.back().end == first)
        runs_.back().end = end;
      else
        runs_.push_back({first, end});
    }
    begin_.push_back(runs_.size());
  }
}

const SliceRuns& EmptySpace::runs(const SliceView& view, const TransferFunction& transfer_function) {
  if (transfer_function != transfer_function_) {
    transfer_function_ = transfer_function;
    for (auto& axis : slices_)
      for (Slice& slice : axis) slice.current = false;
  }
  auto& axis = slices_[std::size_t(view.axis)];
  if (axis.size() <= std::size_t(view.index)) axis.resize(std::size_t(view.index) + 1);
  Slice& slice = axis[std::size_t(view.index)];
  if (!slice.ranges) slice.ranges = std::make_unique<BlockRanges>(view);
  if (!slice.current) {
    slice.runs = SliceRuns(*slice.ranges, transfer_function, view.width);
    slice.current = true;
  }
  return slice.runs;
}

}  // namespace ringsplat
