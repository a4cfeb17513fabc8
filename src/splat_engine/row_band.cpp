#include "splat_engine/row_band.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

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
    : geometry_(frame.geometry),
      rows_(frame.shading),
      dda_(frame.geometry.view, frame.geometry.traversal.axis,
           frame.geometry.grid.slice_width(frame.geometry.traversal.axis)),
      reach_(frame.reach),
      frame_(frame),
      stride_(frame.stride),
      counts_(frame.rects.size()),
      x_(geometry_.view.linear[in_plane(geometry_.traversal.axis).u].x),
      y_(geometry_.view.linear[in_plane(geometry_.traversal.axis).u].y),
      beyond_(double(reach_.x) + 0.51, double(reach_.y) + 0.51) {}

void RowBand::begin(const SliceView& slice, VisibleVoxels& visible, int first, int end) {
  rows_.begin(slice, visible);
  all_in_view_ = is_all_in_view(first, end);
  row_ = first;
  end_ = end;
  visible_ = outside_ = 0;
}

bool RowBand::work(int visible_at_most, int voxels_at_most, StageSeconds* stages) {
  stages_ = stages;
  int visible = 0, voxels = 0;
  while (row_ < end_ && visible < visible_at_most && voxels < voxels_at_most) {
    row_begun_ = false;
    row_offset_ = row_ % stride_;
    const int found = find_row();
    if (found > 0) encode_row(row_);
    visible += found;
    voxels += rows_.slice().width;
    ++row_;
  }
  visible_ += std::uint64_t(visible);
  return row_ >= end_;
}

void RowBand::begin_row() {
  if (std::exchange(row_begun_, true)) return;
  dda_.begin_row(rows_.slice().index, row_);
  x_.begin_row(dda_.row_start().x);
  y_.begin_row(dda_.row_start().y);
}

int RowBand::find_row() {
  const ScopedSeconds timed(stages_ ? &stages_->classify : nullptr);
  const Columns all{0, std::uint32_t(rows_.slice().width)};
  if (all_in_view_) return rows_.find(row_, all);
  const Columns columns = in_view(all);
  const int found = rows_.find(row_, columns);
  outside_ += std::uint64_t(rows_.voxels_outside(columns));
  return found;
}

Columns RowBand::in_view(Columns all) {
  begin_row();
  const Columns columns = reaching_x(0, geometry_.width, all);
  return columns.empty() ? columns : reaching_y(0, geometry_.height, columns);
}

bool RowBand::is_all_in_view(int first, int end) {
  const PixelWindow window = window_of_rows(first, end);
  return window.x0 >= 0 && window.x1 < geometry_.width && window.y0 >= 0 && window.y1 < geometry_.height;
}

PixelWindow RowBand::window_of_rows(int first, int end) {
  row_begun_ = false;
  std::optional<PixelWindow> all;
  for (const int row : {first, std::max(first, end - 1)}) {
    dda_.begin_row(rows_.slice().index, row);
    for (const std::uint32_t column : {0U, std::uint32_t(rows_.slice().width - 1)}) {
      const PixelWindow window = window_of(column);
      all = all ? hull(*all, window) : window;
    }
  }
  return *all;
}

void RowBand::clear_counts() {
  for (const int region : used_) counts_[std::size_t(region)] = {};
  used_.clear();
}

}  // namespace ringsplat
