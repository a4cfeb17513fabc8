#pragma once
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/volume/block_ranges.hpp"
#include "ringsplat/volume/slice_store.hpp"

namespace ringsplat {

/// Half-open run of voxels in a row.
struct ColumnRun {
  int first, end;
};

/// Where a slice can have visible voxels; everywhere else it is transparent.
class SliceRuns {
 public:
  SliceRuns() = default;
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

/// What of a GP's slices a transfer function makes visible: found when a slice is first asked for, and again
/// when the transfer function has changed; the blocks' ranges are found once.
class EmptySpace {
 public:
  /// Valid until the next call with another transfer function.
  const SliceRuns& runs(const SliceView& slice, const TransferFunction& transfer_function);

 private:
  struct Slice {
    std::unique_ptr<BlockRanges> ranges;
    SliceRuns runs;
    bool current = false;  ///< `runs` are those of transfer_function_
  };
  TransferFunction transfer_function_;
  std::array<std::vector<Slice>, 3> slices_;  ///< by axis and index
};

}  // namespace ringsplat
