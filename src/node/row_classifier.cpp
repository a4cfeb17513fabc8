#include "node/row_classifier.hpp"

#include <algorithm>

#include "ringsplat/classify/sample_row.hpp"

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
  const bool lit = shading_.lit() && slice_.normals != nullptr;
  const NormalCode* normals =
      lit ? slice_.normals + std::size_t(row_index_) * std::size_t(slice_.width) : nullptr;
  ringsplat::make_samples(shading_.classifier(), {values(), normals, slice_.width},
                          lit ? &shading_.phong() : nullptr, row_);
}

const std::byte* RowClassifier::values() const {
  return slice_.values + std::size_t(row_index_) * std::size_t(slice_.width) * size_of(slice_.type);
}

}  // namespace ringsplat
