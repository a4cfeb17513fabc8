#include "node/row_classifier.hpp"

#include <algorithm>

namespace ringsplat {

void RowClassifier::begin(const SliceView& slice, const SliceRuns& runs) {
  slice_ = slice;
  runs_ = &runs;
}

int RowClassifier::classify(int row, Columns columns) {
  const std::byte* values =
      slice_.values + std::size_t(row) * std::size_t(slice_.width) * size_of(slice_.type);
  row_.clear();
  voxels_ = 0;
  for (const ColumnRun& run : runs_->of_row(row)) {
    const int first = std::max(run.first, int(columns.first)), end = std::min(run.end, int(columns.end));
    if (first >= end) continue;
    shading_.classifier().classify_row(values, first, end, row_);
    voxels_ += end - first;
  }
  const bool lit = row_.visible > 0 && shading_.lit() && slice_.normals != nullptr;
  normals_ = lit ? slice_.normals + std::size_t(row) * std::size_t(slice_.width) : nullptr;
  return int(row_.visible);
}

void RowClassifier::shade() {
  if (normals_ != nullptr) shading_.phong().shade(normals_, row_);
}

}  // namespace ringsplat
