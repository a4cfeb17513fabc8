#include "node/row_band.hpp"

#include "ringsplat/base/clock.hpp"

namespace ringsplat {

RowBand::RowBand(const EncoderFrame& frame)
    : geometry_(frame.geometry),
      rows_(frame.shading),
      dda_(frame.geometry.view, frame.geometry.traversal.axis,
           frame.geometry.grid.slice_width(frame.geometry.traversal.axis)),
      x_(geometry_.view.linear[in_plane(geometry_.traversal.axis).u].x),
      y_(geometry_.view.linear[in_plane(geometry_.traversal.axis).u].y),
      reach_(frame.reach),
      beyond_(double(reach_.x) + 0.51, double(reach_.y) + 0.51),
      frame_(frame),
      stride_(frame.stride),
      counts_(frame.rects.size()) {}

void RowBand::begin(const SliceView& slice, const SliceRuns& runs, int first, int end) {
  rows_.begin(slice, runs);
  visible_ = 0;
  all_in_view_ = is_all_in_view(first, end);
  row_ = first;
  end_ = end;
}

bool RowBand::work(int visible_at_most, int voxels_at_most, StageSeconds* stages) {
  int visible = 0, voxels = 0;
  for (; row_ < end_ && visible < visible_at_most && voxels < voxels_at_most; ++row_) {
    begin_row();
    const Columns columns = in_view();
    if (columns.empty()) continue;
    const int found = classify_row(columns, stages);
    if (found > 0) encode_row(row_);
    visible += found;
    voxels += rows_.voxels();
  }
  visible_ += std::uint64_t(visible);
  return row_ >= end_;
}

void RowBand::begin_row() {
  dda_.begin_row(rows_.slice().index, row_);
  x_.begin_row(dda_.row_start().x);
  y_.begin_row(dda_.row_start().y);
  row_offset_ = row_ % stride_;
}

Columns RowBand::in_view() const {
  const Columns all{0, std::uint32_t(rows_.slice().width)};
  if (all_in_view_) return all;
  const Columns columns = x_.within(-beyond_.x, double(geometry_.width) + beyond_.x, all);
  if (columns.empty()) return columns;
  return y_.within(-beyond_.y, double(geometry_.height) + beyond_.y, columns);
}

/// Positions run straight, so the corners tell.
bool RowBand::is_all_in_view(int first, int end) {
  if (first >= end) return true;
  const auto is_inside = [this](std::uint32_t column) {
    const PixelWindow window = window_of(column);
    return window.x0 >= 0 && window.x1 < geometry_.width && window.y0 >= 0 && window.y1 < geometry_.height;
  };
  for (const int row : {first, end - 1}) {
    dda_.begin_row(rows_.slice().index, row);
    if (!is_inside(0) || !is_inside(std::uint32_t(rows_.slice().width - 1))) return false;
  }
  return true;
}

int RowBand::classify_row(Columns columns, StageSeconds* stages) {
  int found;
  {
    const OptionalSeconds timed(stages ? &stages->classify : nullptr);
    found = rows_.classify(row_, columns);
  }
  const OptionalSeconds timed(stages ? &stages->shade : nullptr);
  rows_.shade();
  return found;
}

void RowBand::clear_counts() {
  for (const int region : used_) counts_[std::size_t(region)] = {};
  used_.clear();
}

}  // namespace ringsplat
