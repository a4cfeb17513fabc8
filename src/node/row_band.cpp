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
      counts_(frame.rects.size()) {}

void RowBand::begin(const SliceView& slice, const SliceRuns& runs, int first, int end) {
  rows_.begin(slice, runs);
  row_ = first;
  end_ = end;
  visible_ = 0;
}

bool RowBand::work(int visible_at_most, int voxels_at_most, StageSeconds* stages) {
  stages_ = stages;
  int visible = 0, voxels = 0;
  while (row_ < end_ && visible < visible_at_most && voxels < voxels_at_most) {
    const int found = find_row();
    if (found > 0) {
      dda_.begin_row(rows_.slice().index, row_);
      row_offset_ = row_ % stride_;
      encode_row(row_);
    }
    visible += found;
    voxels += rows_.voxels();
    ++row_;
  }
  visible_ += std::uint64_t(visible);
  return row_ >= end_;
}

int RowBand::find_row() {
  const OptionalSeconds timed(stages_ ? &stages_->classify : nullptr);
  return rows_.find(row_);
}

void RowBand::clear_counts() {
  for (const int region : used_) counts_[std::size_t(region)] = {};
  used_.clear();
}

}  // namespace ringsplat
