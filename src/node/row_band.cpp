#include "node/row_band.hpp"

namespace ringsplat {

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
    const int found = find_row();
    if (found > 0) {
      if (all_in_view_) begin_row();  // else in_view() has
      encode_row(row_);
    }
    visible += found;
    voxels += rows_.slice().width;
    ++row_;
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

int RowBand::find_row() {
  const OptionalSeconds timed(stages_ ? &stages_->classify : nullptr);
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

/// Positions run straight, so the corners tell.
bool RowBand::is_all_in_view(int first, int end) {
  const auto is_inside = [this](std::uint32_t column) {
    const PixelWindow window = window_of(column);
    return window.x0 >= 0 && window.x1 < geometry_.width && window.y0 >= 0 && window.y1 < geometry_.height;
  };
  for (const int row : {first, std::max(first, end - 1)}) {
    dda_.begin_row(rows_.slice().index, row);
    if (!is_inside(0) || !is_inside(std::uint32_t(rows_.slice().width - 1))) return false;
  }
  return true;
}

void RowBand::clear_counts() {
  for (const int region : used_) counts_[std::size_t(region)] = {};
  used_.clear();
}

}  // namespace ringsplat
