#include "node/row_classifier.hpp"

namespace ringsplat {

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
    shading_.classifier().classify_row(values, run.first, run.end, row_);
    voxels_ += run.end - run.first;
  }
  const bool lit = row_.visible > 0 && shading_.lit() && slice_.normals != nullptr;
  normals_ = lit ? slice_.normals + std::size_t(row) * std::size_t(slice_.width) : nullptr;
  return int(row_.visible);
}

void RowClassifier::shade() {
  if (normals_ != nullptr) shading_.phong().shade(normals_, row_);
}

}  // namespace ringsplat
