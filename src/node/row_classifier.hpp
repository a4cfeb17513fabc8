#pragma once
#include "node/empty_space.hpp"
#include "node/frame_shading.hpp"
#include "node/row_axis.hpp"

namespace ringsplat {

/// The visible voxels of one frame's slices, row by row: first where they are, then, of those that are kept,
/// their lit samples. Empty space is not read.
class RowClassifier {
 public:
  /// `shading` must outlive it.
  explicit RowClassifier(const FrameShading& shading) : shading_(shading) {}

  /// `runs` must stay valid until the slice is done.
  void begin(const SliceView& slice, const SliceRuns& runs);
  const SliceView& slice() const { return slice_; }

  /// Finds the visible voxels in columns of row `row` of the slice; returns how many. What follows speaks of
  /// this row.
  int find(int row, Columns columns);
  int voxels() const { return voxels_; }           ///< read for it
  int voxels_outside() const { return outside_; }  ///< in other columns, where some may be visible
  /// Where they are, by ascending columns.
  std::span<const VisibleBlock> blocks() const { return row_.blocks; }
  /// Leaves those that `kept`, a mask for each block, has.
  void keep(const std::vector<std::uint64_t>& kept) { row_.keep(kept); }
  void make_samples();  ///< once, before they are asked for
  /// Straight colours and corrected opacities.
  std::span<const ClassifiedSample> samples() const { return std::span(row_.samples).first(row_.visible); }

 private:
  const std::byte* values() const;  ///< of the row

  const FrameShading& shading_;
  SliceView slice_;
  const SliceRuns* runs_ = nullptr;
  int row_index_ = 0, voxels_ = 0, outside_ = 0;
  VisibleRow row_;
};

}  // namespace ringsplat
