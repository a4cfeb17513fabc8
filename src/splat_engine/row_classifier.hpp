#pragma once
#include "classify/empty_space.hpp"
#include "frame/frame_shading.hpp"
#include "splat_engine/row_axis.hpp"

namespace ringsplat {

/// The visible voxels of one frame's slices, row by row: first where they are, then, of those that are kept,
/// their lit samples. Only these are read, but for a row's first time.
class RowClassifier {
 public:
  /// `shading` must outlive it.
  explicit RowClassifier(const FrameShading& shading) : shading_(shading) {}

  /// `visible`, the slice's, must stay valid until it is done.
  void begin(const SliceView& slice, VisibleVoxels& visible);
  const SliceView& slice() const { return slice_; }

  /// Finds the visible voxels in columns of row `row` of the slice; returns how many. What follows speaks of
  /// this row.
  int find(int row, Columns columns);
  /// Of the row, in other columns, where some may be visible.
  int voxels_outside(Columns columns) const;
  /// Where they are, by ascending columns.
  std::span<const VisibleBlock> blocks() const { return row_.blocks; }
  /// Leaves those that `kept`, a mask for each block, has.
  void keep(const std::vector<std::uint64_t>& kept) { row_.keep(kept); }
  void make_samples();  ///< once, before they are asked for
  /// Straight colours and corrected opacities.
  std::span<const ClassifiedSample> samples() const { return std::span(row_.samples).first(row_.visible); }

 private:
  const FrameShading& shading_;
  SliceView slice_;
  VisibleVoxels* visible_ = nullptr;
  int row_index_ = 0;
  VisibleRow row_;
};

}  // namespace ringsplat
