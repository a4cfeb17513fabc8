#include "splat_engine/row_band.hpp"

namespace ringsplat {

EncoderFrame::EncoderFrame(const SplatFrame& splat_frame)
    : frame(splat_frame),
      geometry(frame.geometry),
      classifier(frame.shown.transfer_function, geometry.grid.type,
                 frame.shown.opacity_correction ? geometry.traversal.slice_distance
                                                : double(frame.shown.reduction.factor)),
      reach(kernel_reach(frame.footprint)),
      stride(pass_stride(frame.splats.kernel_radius)) {
  const ViewTransform& view = geometry.view;
  const glm::dvec3& light = frame.shown.light;
  if (frame.shown.shading == Shading::phong)
    phong.emplace(frame.shown.material, view.right * light.x + view.up * light.y + view.to_viewer * light.z,
                  view.to_viewer);
  for (int region = 0; region < geometry.regions.count(); ++region) {
    rects.push_back(geometry.regions.rect(region));
    opaque.emplace_back(rects.back().width(), rects.back().height());
  }
}

std::vector<int> row_bounds(const SliceRuns& runs, int height, int most) {
  if (runs.empty()) return {0};
  if (most == 1) return {0, height};
  std::vector<std::int64_t> before{0};  // by row: possibly visible voxels in the rows before
  for (int row = 0; row < height; ++row) {
    std::int64_t voxels = 0;
    for (const ColumnRun& run : runs.of_row(row)) voxels += run.end - run.first;
    before.push_back(before.back() + voxels);
  }
  // Waking a thread costs as much as some hundred voxels.
  constexpr std::int64_t worth_a_thread = 256;
  const auto bands = std::clamp<std::int64_t>(before.back() / worth_a_thread, 1, most);
  std::vector<int> bounds{0};
  for (std::int64_t band = 1; band < bands; ++band) {
    const auto cut = std::lower_bound(before.begin(), before.end(), before.back() * band / bands);
    const int row = int(cut - before.begin());
    if (row > bounds.back() && row < height) bounds.push_back(row);
  }
  bounds.push_back(height);
  return bounds;
}

RowBand::RowBand(const EncoderFrame& frame)
    : frame_(frame),
      dda_(frame.geometry.view, frame.geometry.traversal.axis,
           frame.geometry.grid.slice_width(frame.geometry.traversal.axis)),
      counts_(frame.rects.size()),
      inverse_step_(1.0 / glm::dvec2(frame.geometry.view.linear[in_plane(frame.geometry.traversal.axis).u])),
      beyond_(double(frame.reach.x) + 0.51, double(frame.reach.y) + 0.51) {}

void RowBand::begin(const SliceView& slice, VisibleVoxels& voxels, int first, int end) {
  slice_ = slice;
  voxels_ = &voxels;
  row_ = first;
  end_ = end;
  visible_ = outside_ = 0;
}

bool RowBand::work(int visible_at_most, int voxels_at_most) {
  int visible = 0, voxels = 0;
  for (; row_ < end_ && visible < visible_at_most && voxels < voxels_at_most; ++row_) {
    row_offset_ = row_ % frame_.stride;
    find_row();
    visible += int(found_.visible);
    voxels += slice_.width;
    if (found_.visible > 0) encode_row(row_);
  }
  visible_ += std::uint64_t(visible);
  return row_ >= end_;
}

void RowBand::find_row() {
  const auto runs = voxels_->runs().of_row(row_);
  if (runs.empty()) return found_.take({}, 0, 0);
  dda_.begin_row(slice_.index, row_);
  Columns columns = reaching(0, 0, frame_.geometry.width, {0, std::uint32_t(slice_.width)});
  if (!columns.empty()) columns = reaching(1, 0, frame_.geometry.height, columns);
  for (const ColumnRun& run : runs) {
    const int first = std::max(run.first, int(columns.first)), end = std::min(run.end, int(columns.end));
    outside_ += std::uint64_t(run.end - run.first - std::max(end - first, 0));
  }
  if (columns.empty())
    found_.take({}, 0, 0);
  else
    found_.take(voxels_->of_row(slice_, row_), columns.first, columns.end);
}

std::span<const ClassifiedSample> RowBand::make_samples() {
  const NormalCode* normals = frame_.phong ? slice_.normals_of_row(row_) : nullptr;
  ringsplat::make_samples(frame_.classifier, {slice_.values_of_row(row_), normals, slice_.width},
                          frame_.phong ? &*frame_.phong : nullptr, found_);
  return std::span(found_.samples).first(found_.visible);
}

void RowBand::clear_counts() {
  for (const int region : used_) counts_[std::size_t(region)] = {};
  used_.clear();
}

}  // namespace ringsplat
