#pragma once
#include <optional>
#include <vector>

#include "node/empty_space.hpp"
#include "ringsplat/classify/classifier.hpp"
#include "ringsplat/classify/phong.hpp"
#include "ringsplat/node/frame_spec.hpp"

namespace ringsplat {

/// The visible voxels of one frame's slices, row by row: classified at once, shaded one by one when they are wanted, since
/// some turn out to be hidden. Empty space is not read.
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
  /// Columns of the visible voxels, ascending.
  std::span<const std::uint32_t> columns() const { return std::span(columns_).first(std::size_t(visible_)); }
  /// Colour and corrected opacity of the k-th visible voxel.
  ClassifiedSample shaded(int k) const {
    const ClassifiedSample& sample = samples_[std::size_t(k)];
    return normals_ != nullptr ? phong_->shade(normals_[columns_[std::size_t(k)]], sample) : sample;
  }
  /// Shades all of the row's visible voxels now.
  void shade_all();

 private:
  const FrameSpec& spec_;
  const FrameGeometry& geometry_;
  Classifier classifier_;
  std::optional<PhongTable> phong_;  ///< made when the first visible voxel is found
  SliceView slice_;
  const SliceRuns* runs_ = nullptr;
  const NormalCode* normals_ = nullptr;  ///< of the row
  int visible_ = 0, voxels_ = 0;
  std::vector<std::uint32_t> columns_;
  std::vector<ClassifiedSample> samples_;
};

}  // namespace ringsplat
