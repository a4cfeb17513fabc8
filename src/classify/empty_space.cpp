#include "classify/empty_space.hpp"

#include <algorithm>
#include <utility>

#include "volume/slice_ranges.hpp"

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

VisibleVoxels::VisibleVoxels(SliceRuns runs, const Classifier& finder, int width, int height)
    : runs_(std::move(runs)), finder_(&finder), row_masks_(masks_of(width)) {
  if (runs_.empty()) return;
  masks_.assign(std::size_t(height) * row_masks_, 0);
  found_.assign(std::size_t(height), 0);
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

const std::vector<bool>& EmptySpace::shown_slices(const SliceStore& store, Axis axis,
                                                  const TransferFunction& transfer_function) {
  if (transfer_function != shown_function_) {
    shown_function_ = transfer_function;
    for (auto& of_axis : shown_) of_axis.clear();
  }
  std::vector<bool>& shown = shown_[std::size_t(axis)];
  if (!shown.empty()) return shown;
  shown.assign(std::size_t(store.grid().slices(axis)), true);
  if (store.ranges() == nullptr) return shown;
  for (const SliceRange& range : store.ranges()->of(axis))
    shown[std::size_t(range.slice)] = transfer_function.visible_within(range.low, range.high);
  return shown;
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
      for (Slice& slice : axis) slice.current = false;
  }
  auto& axis = slices_[std::size_t(view.axis)];
  if (axis.size() <= std::size_t(view.index)) axis.resize(std::size_t(view.index) + 1);
  Slice& slice = axis[std::size_t(view.index)];
  if (!slice.ranges) slice.ranges = std::make_unique<BlockRanges>(view);
  if (!slice.current) {
    slice.voxels = {SliceRuns(*slice.ranges, transfer_function, view.width), *finder_, view.width,
                    view.height};
    slice.current = true;
  }
  return slice.voxels;
}

}  // namespace ringsplat
