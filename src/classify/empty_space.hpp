#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "classify/classifier.hpp"
#include "volume/cell_ranges.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// Half-open run of voxels in a row.
struct ColumnRun {
  int first, end;
};

/// Where a slice can have visible voxels; everywhere else it is transparent.
class SliceRuns {
 public:
  SliceRuns(const BlockRanges& ranges, const TransferFunction& transfer_function, int width);
  bool empty() const { return runs_.empty(); }
  std::span<const ColumnRun> of_row(int row) const {
    const auto block = std::size_t(row / BlockRanges::block_height);
    return std::span(runs_).subspan(begin_[block], begin_[block + 1] - begin_[block]);
  }

 private:
  std::vector<std::size_t> begin_;  ///< by row of blocks, one more at the end
  std::vector<ColumnRun> runs_;
};

/// The visible voxels of a slice, a bit each: found when a row is first asked for, and kept, as Lacroute and
/// Levoy 1994 (section 3.1) keep their runs, for all views of a transfer function.
class VisibleVoxels {
 public:
  /// `finder` must outlive it; how far it corrects opacities does not matter.
  VisibleVoxels(SliceRuns runs, const Classifier& finder, int width, int height)
      : runs_(std::move(runs)), finder_(&finder), row_masks_(masks_of(width)) {
    if (runs_.empty()) return;
    masks_.assign(std::size_t(height) * row_masks_, 0);
    found_.assign(std::size_t(height), 0);
  }
  const SliceRuns& runs() const { return runs_; }
  /// A row's masks, masks_of(width) of them. `slice` is the one whose runs these are. Several threads may ask
  /// for different rows.
  std::span<const std::uint64_t> of_row(const SliceView& slice, int row);

 private:
  SliceRuns runs_;
  const Classifier* finder_;
  std::size_t row_masks_;
  std::vector<std::uint64_t> masks_;  ///< [row][masks_of(width)]; none of a slice without runs
  std::vector<std::uint8_t> found_;   ///< by row: 1 when its masks are known
};

/// What of a GP's slices, all of one scalar type, a transfer function makes visible: found when a slice is
/// first asked for, and again when the transfer function or the part of the volume has changed; the blocks'
/// ranges are found once for a part.
class EmptySpace {
 public:
  /// `box`: the part of the volume whose slice it is; slices of one part are kept. Valid until the next call
  /// with another transfer function or part.
  VisibleVoxels& voxels(const SliceView& slice, const TransferFunction& transfer_function,
                        const VoxelBox& box = {});

 private:
  struct Slice {
    std::unique_ptr<BlockRanges> ranges;
    std::optional<VisibleVoxels> voxels;  ///< of transfer_function_
  };
  VoxelBox box_;  ///< the part whose slices are kept
  TransferFunction transfer_function_;
  std::optional<Classifier> finder_;          ///< its
  std::array<std::vector<Slice>, 3> slices_;  ///< by axis and index
};

}  // namespace ringsplat
