#pragma once
#include <optional>
#include <vector>

#include "node/empty_space.hpp"
#include "ringsplat/classify/classifier.hpp"
#include "ringsplat/classify/phong.hpp"
#include "ringsplat/node/frame_spec.hpp"

namespace ringsplat {

/// The visible voxels of one frame's slices, row by row: classified and then shaded. Empty space is not read.
class RowClassifier {
 public:
  RowClassifier(const FrameSpec& spec, const FrameGeometry& geometry);

  /// `runs` must stay valid until the slice is done.
  void begin(const SliceView& slice, const SliceRuns& runs);
  const SliceView& slice() const { return slice_; }
  bool empty() const { return runs_->empty(); }

  /// Classifies row `row` of the slice; returns how many voxels are visible. What follows speaks of this row.
  int classify(int row);
  void shade();                           ///< once, before samples are asked for
  int voxels() const { return voxels_; }  ///< read for it
  /// Runs of visible voxels, by ascending columns, never adjacent.
  std::span<const VisibleRun> runs() const { return row_.runs; }
  /// Straight colours and corrected opacities of the visible voxels, run after run.
  std::span<const ClassifiedSample> samples() const { return std::span(row_.samples).first(row_.visible); }

 private:
  const FrameSpec& spec_;
  const FrameGeometry& geometry_;
  Classifier classifier_;
  std::optional<PhongTable> phong_;  ///< made when the first visible voxel is found
  SliceView slice_;
  const SliceRuns* runs_ = nullptr;
  int voxels_ = 0;
  VisibleRow row_;
  const NormalCode* normals_ = nullptr;  ///< of the row; null when it needs none
};

}  // namespace ringsplat
