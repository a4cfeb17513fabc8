#pragma once
#include <optional>
#include <vector>

#include "node/empty_space.hpp"
#include "ringsplat/classify/classifier.hpp"
#include "ringsplat/classify/phong.hpp"
#include "ringsplat/node/frame_spec.hpp"

namespace ringsplat {

/// The visible voxels of one frame's slices, row by row: classified at once, shaded when they are wanted,
/// since some turn out to be hidden. Empty space is not read.
class RowClassifier {
 public:
  RowClassifier(const FrameSpec& spec, const FrameGeometry& geometry);

  /// `runs` must stay valid until the slice is done.
  void begin(const SliceView& slice, const SliceRuns& runs);
  const SliceView& slice() const { return slice_; }
  bool empty() const { return runs_->empty(); }

  /// Classifies row `row` of the slice; returns how many voxels are visible. What follows speaks of this row.
  int classify(int row);
  int voxels() const { return voxels_; }  ///< read for it
  std::uint32_t visible() const { return row_.visible; }
  /// Runs of visible voxels, by ascending columns, never adjacent.
  std::span<const VisibleRun> runs() const { return row_.runs; }
  /// Straight colours, shaded, and corrected opacities of the visible voxels begin … end − 1, counted from
  /// the row's first. Valid until the next call.
  std::span<const ClassifiedSample> lit(std::uint32_t begin, std::uint32_t end);
  /// Shades all of the row's visible voxels now.
  void shade_all();

 private:
  void find_normals(int row);

  const FrameSpec& spec_;
  const FrameGeometry& geometry_;
  Classifier classifier_;
  std::optional<PhongTable> phong_;  ///< made when the first visible voxel is found
  SliceView slice_;
  const SliceRuns* runs_ = nullptr;
  int voxels_ = 0;
  VisibleRow row_;
  bool unlit_ = false;               ///< the row's samples are still to be shaded
  std::vector<NormalCode> normals_;  ///< of the row's visible voxels
  std::vector<ClassifiedSample> lit_;
};

}  // namespace ringsplat
