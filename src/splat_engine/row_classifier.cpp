#include "splat_engine/row_classifier.hpp"

#include <algorithm>

#include "classify/sample_row.hpp"

namespace ringsplat {

void RowClassifier::begin(const SliceView& slice, VisibleVoxels& visible) {
  slice_ = slice;
  visible_ = &visible;
}

int RowClassifier::find(int row, Columns columns) {
  row_index_ = row;
  if (columns.empty() || visible_->runs().of_row(row).empty())
    row_.take({}, 0, 0);
  else
    row_.take(visible_->of_row(slice_, row), columns.first, columns.end);
  return int(row_.visible);
}

int RowClassifier::voxels_outside(Columns columns) const {
  int outside = 0;
  for (const ColumnRun& run : visible_->runs().of_row(row_index_)) {
    const int first = std::max(run.first, int(columns.first)), end = std::min(run.end, int(columns.end));
    outside += run.end - run.first - std::max(end - first, 0);
  }
  return outside;
}

void RowClassifier::make_samples() {
  const NormalCode* normals = shading_.lit() ? slice_.normals_of_row(row_index_) : nullptr;
  ringsplat::make_samples(shading_.classifier(), {slice_.values_of_row(row_index_), normals, slice_.width},
                          normals == nullptr ? nullptr : &shading_.phong(), row_);
}

}  // namespace ringsplat
