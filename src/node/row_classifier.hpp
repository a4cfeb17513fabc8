#pragma once
#include "node/empty_space.hpp"
#include "node/frame_shading.hpp"

namespace ringsplat {

/// The visible voxels of one frame's slices, row by row: classified and then shaded. Empty space is not read.
class RowClassifier {
 public:
  /// `shading` must outlive it.
  explicit RowClassifier(const FrameShading& shading) : shading_(shading) {}

  /// `runs` must stay valid until the slice is done.
  void begin(const SliceView& slice, const SliceRuns& runs);
  const SliceView& slice() const { return slice_; }

  /// Classifies row `row` of the slice; returns how many voxels are visible. What follows speaks of this row.
  int classify(int row);
  void shade();                           ///< once, before samples are asked for
  int voxels() const { return voxels_; }  ///< read for it
  /// Where the row's visible voxels are, by ascending columns.
  std::span<const VisibleBlock> blocks() const { return row_.blocks; }
  /// The visible voxels' columns, ascending.
  std::span<const std::uint32_t> columns() const { return std::span(row_.columns).first(row_.visible); }
  /// Their straight colours and corrected opacities.
  std::span<const ClassifiedSample> samples() const { return std::span(row_.samples).first(row_.visible); }

 private:
  const FrameShading& shading_;
  SliceView slice_;
  const SliceRuns* runs_ = nullptr;
  int voxels_ = 0;
  VisibleRow row_;
  const NormalCode* normals_ = nullptr;  ///< of the row; null when it needs none
};

}  // namespace ringsplat
