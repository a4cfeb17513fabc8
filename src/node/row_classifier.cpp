#include "node/row_classifier.hpp"

#include <algorithm>

#include "ringsplat/classify/sample_row.hpp"

namespace ringsplat {

void RowClassifier::begin(const SliceView& slice, const SliceRuns& runs) {
  slice_ = slice;
  runs_ = &runs;
}

int RowClassifier::find(int row, Columns columns) {
  row_index_ = row;
  row_.clear();
  voxels_ = outside_ = 0;
  for (const ColumnRun& run : runs_->of_row(row)) {
    const int first = std::max(run.first, int(columns.first)), end = std::min(run.end, int(columns.end)),
              inside = std::max(end - first, 0);
    if (inside > 0) shading_.classifier().find_row(values(), first, end, row_);
    voxels_ += inside;
    outside_ += run.end - run.first - inside;
  }
  return int(row_.visible);
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
