#include "classify/empty_space.hpp"

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

std::span<const std::uint64_t> VisibleVoxels::of_row(const SliceView& slice, int row) {
  if (runs_.empty()) return {};
  std::uint64_t* masks = masks_.data() + std::size_t(row) * row_masks_;
  if (std::exchange(found_[std::size_t(row)], 1) == 0) {
    const std::byte* values = slice.values_of_row(row);
    for (const ColumnRun& run : runs_.of_row(row)) finder_->find_row(values, run.first, run.end, masks);
  }
  return {masks, row_masks_};
}

VisibleVoxels& EmptySpace::voxels(const SliceView& view, const TransferFunction& transfer_function,
                                  const VoxelBox& box) {
  if (box != box_) {
    box_ = box;
    for (auto& axis : slices_) axis.clear();
  }
  if (!finder_ || transfer_function != transfer_function_) {
    transfer_function_ = transfer_function;
    finder_.emplace(transfer_function_, view.type, 1.0);
    for (auto& axis : slices_)
      for (Slice& slice : axis) slice.voxels.reset();
  }
  auto& axis = slices_[std::size_t(view.axis)];
  if (axis.size() <= std::size_t(view.index)) axis.resize(std::size_t(view.index) + 1);
  Slice& slice = axis[std::size_t(view.index)];
  if (!slice.ranges) slice.ranges = std::make_unique<BlockRanges>(view);
  if (!slice.voxels)
    slice.voxels.emplace(SliceRuns(*slice.ranges, transfer_function, view.width), *finder_, view.width,
                         view.height);
  return *slice.voxels;
}

}  // namespace ringsplat
