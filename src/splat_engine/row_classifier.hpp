#pragma once
#include "classify/empty_space.hpp"
#include "frame/frame_shading.hpp"
#include "splat_engine/row_axis.hpp"

namespace ringsplat {

/// Finds the visible voxels of one frame's slices row by row, then makes the lit samples of those that are
/// kept. After a row's first search only kept voxels are read.
class RowClassifier {
 public:
  /// `shading` must outlive it.
  explicit RowClassifier(const FrameShading& shading) : shading_(shading) {}

  /// `visible` belongs to the slice and must outlive the work on it.
  void begin(const SliceView& slice, VisibleVoxels& visible);
  const SliceView& slice() const { return slice_; }

  /// Finds the visible voxels in these columns of row `row`; returns how many. The functions below refer to
  /// this row.
  int find(int row, Columns columns);
  /// Number of the row's voxels outside `columns` that may be visible.
  int voxels_outside(Columns columns) const;
  /// The visible voxels, by ascending columns.
  std::span<const VisibleBlock> blocks() const { return row_.blocks; }
  /// Keeps only the voxels in `kept`, a mask for each block.
  void keep(const std::vector<std::uint64_t>& kept) { row_.keep(kept); }
  void make_samples();  ///< call once before samples()
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
