#include "node/row_classifier.hpp"

namespace ringsplat {

RowClassifier::RowClassifier(const FrameSpec& spec, const FrameGeometry& geometry)
    : spec_(spec),
      geometry_(geometry),
      classifier_(
          spec.transfer_function, geometry.grid.type,
          spec.opacity_correction ? geometry.traversal.slice_distance : double(spec.reduction.factor)) {}

void RowClassifier::begin(const SliceView& slice, const SliceRuns& runs) {
  slice_ = slice;
  runs_ = &runs;
}

int RowClassifier::classify(int row) {
  const std::byte* values =
      slice_.values + std::size_t(row) * std::size_t(slice_.width) * size_of(slice_.type);
  row_.clear();
  voxels_ = 0;
  for (const ColumnRun& run : runs_->of_row(row)) {
    classifier_.classify_row(values, run.first, run.end, row_);
    voxels_ += run.end - run.first;
  }
  const bool lit = row_.visible > 0 && spec_.shading == Shading::phong && slice_.normals != nullptr;
  normals_ = lit ? slice_.normals + std::size_t(row) * std::size_t(slice_.width) : nullptr;
  return int(row_.visible);
}

void RowClassifier::shade() {
  if (normals_ == nullptr) return;
  if (!phong_) {
    const ViewTransform& view = geometry_.view;
    phong_.emplace(spec_.material,
                   view.right * spec_.light.x + view.up * spec_.light.y + view.to_viewer * spec_.light.z,
                   view.to_viewer);
  }
  phong_->shade(normals_, row_);
}

}  // namespace ringsplat
