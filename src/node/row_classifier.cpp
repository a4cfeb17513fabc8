#include "node/row_classifier.hpp"

namespace ringsplat {

RowClassifier::RowClassifier(const FrameSpec& spec, const FrameGeometry& geometry)
    : spec_(spec),
      geometry_(geometry),
      classifier_(spec.transfer_function, geometry.grid.type, spec.opacity_correction ? geometry.traversal.slice_distance : double(spec.reduction.factor)),
      columns_(std::size_t(geometry.grid.slice_width(geometry.traversal.axis))),
      samples_(columns_.size()) {}

void RowClassifier::begin(const SliceView& slice, const SliceRuns& runs) {
  slice_ = slice;
  runs_ = &runs;
}

int RowClassifier::classify(int row) {
  const std::size_t first = std::size_t(row) * std::size_t(slice_.width);
  const std::byte* values = slice_.values + first * size_of(slice_.type);
  visible_ = voxels_ = 0;
  for (const ColumnRun& run : runs_->of_row(row)) {
    std::uint32_t* columns = columns_.data() + visible_;
    const int found = classifier_.classify_row(values + std::size_t(run.first) * size_of(slice_.type), run.end - run.first, columns,
                                               samples_.data() + visible_);
    for (int k = 0; k < found; ++k) columns[k] += std::uint32_t(run.first);
    visible_ += found;
    voxels_ += run.end - run.first;
  }
  normals_ = nullptr;
  if (visible_ > 0 && spec_.shading == Shading::phong && slice_.normals != nullptr) {
    normals_ = slice_.normals + first;
    if (!phong_) {
      const ViewTransform& view = geometry_.view;
      phong_.emplace(spec_.material, view.right * spec_.light.x + view.up * spec_.light.y + view.to_viewer * spec_.light.z,
                     view.to_viewer);
    }
    // The table does not stay in the nearest cache beside slices and images; asked for early, its entries are there in time.
    for (int k = 0; k < visible_; ++k) phong_->prefetch(normals_[columns_[std::size_t(k)]]);
  }
  return visible_;
}

void RowClassifier::shade_all() {
  for (int k = 0; k < visible_; ++k) samples_[std::size_t(k)] = shaded(k);
  normals_ = nullptr;
}

}  // namespace ringsplat
