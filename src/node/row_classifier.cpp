#include "node/row_classifier.hpp"

#include <algorithm>
#include <utility>

namespace ringsplat {

RowClassifier::RowClassifier(const FrameSpec& spec, const FrameGeometry& geometry)
    : spec_(spec),
      geometry_(geometry),
      classifier_(
          spec.transfer_function, geometry.grid.type,
          spec.opacity_correction ? geometry.traversal.slice_distance : double(spec.reduction.factor)),
      normals_(std::size_t(geometry.grid.slice_width(geometry.traversal.axis))),
      lit_(normals_.size()) {}

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
  unlit_ = row_.visible > 0 && spec_.shading == Shading::phong && slice_.normals != nullptr;
  if (unlit_) find_normals(row);
  return int(row_.visible);
}

void RowClassifier::find_normals(int row) {
  if (!phong_) {
    const ViewTransform& view = geometry_.view;
    phong_.emplace(spec_.material,
                   view.right * spec_.light.x + view.up * spec_.light.y + view.to_viewer * spec_.light.z,
                   view.to_viewer);
  }
  const NormalCode* normals = slice_.normals + std::size_t(row) * std::size_t(slice_.width);
  for (const VisibleRun& run : row_.runs)
    std::copy_n(normals + run.first, run.count, normals_.data() + run.sample);
}

std::span<const ClassifiedSample> RowClassifier::lit(std::uint32_t begin, std::uint32_t end) {
  const auto samples = std::span(std::as_const(row_.samples)).subspan(begin, end - begin);
  if (!unlit_) return samples;
  phong_->shade(normals_.data() + begin, samples.data(), samples.size(), lit_.data());
  return std::span(std::as_const(lit_)).first(samples.size());
}

void RowClassifier::shade_all() {
  if (unlit_) phong_->shade(normals_.data(), row_.samples.data(), row_.visible, row_.samples.data());
  unlit_ = false;
}

}  // namespace ringsplat
