#include "node/slice_encoder.hpp"

#include <algorithm>
#include <bit>

#include "node/opaque_news.hpp"
#include "ringsplat/base/clock.hpp"
#include "ringsplat/net/message.hpp"

namespace ringsplat {

SliceEncoder::SliceEncoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers,
                           EmptySpace& empty_space)
    : geometry_(geometry),
      rows_(spec, geometry),
      dda_(geometry.view, geometry.traversal.axis, geometry.grid.slice_width(geometry.traversal.axis)),
      reach_(kernel_reach(geometry.footprint)),
      spec_(spec),
      empty_space_(empty_space),
      renderers_(renderers),
      stride_(pass_stride(spec.kernel_radius)),
      counts_(std::size_t(geometry.regions.count())),
      covers_(counts_.size()) {
  opaque_.reserve(counts_.size());
  for (int region = 0; region < geometry.regions.count(); ++region) {
    rects_.push_back(geometry.regions.rect(region));
    opaque_.emplace_back(rects_.back().width(), rects_.back().height());
  }
}

void SliceEncoder::begin(const SliceView& slice) {
  rows_.begin(slice, empty_space_.runs(slice, spec_.transfer_function));
  row_ = 0;
  visible_ = 0;
}

bool SliceEncoder::work() {
  // Bounded by what costs: visible voxels, or many transparent ones.
  constexpr int visible_at_most = 1024, voxels_at_most = 16384;
  const int height = rows_.empty() ? 0 : rows_.slice().height;
  int visible = 0, voxels = 0;
  while (row_ < height && visible < visible_at_most && voxels < voxels_at_most) {
    const int found = classify_row();
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
  return row_ >= height;
}

int SliceEncoder::classify_row() {
  int found;
  {
    const OptionalSeconds timed(stages_ ? &stages_->classify : nullptr);
    found = rows_.classify(row_);
  }
  const OptionalSeconds timed(stages_ ? &stages_->shade : nullptr);
  rows_.shade();
  return found;
}

EncodedSlice SliceEncoder::finish() {
  EncodedSlice encoded;
  encoded.payloads.resize(std::size_t(renderers_));
  encoded.splats.resize(std::size_t(renderers_));
  encoded.passes.resize(std::size_t(renderers_));
  encoded.visible_voxels = visible_;
  encoded.voxels = std::uint64_t(rows_.slice().width) * std::uint64_t(rows_.slice().height);
  std::sort(used_.begin(), used_.end());
  std::vector<std::size_t> sizes(std::size_t(renderers_), 0);
  for (const int region : used_) sizes[std::size_t(Regions::owner(region, renderers_))] += part_bytes(region);
  for (const int region : used_) {
    const auto owner = std::size_t(Regions::owner(region, renderers_));
    Bytes& payload = encoded.payloads[owner];
    if (payload.empty()) {
      payload = Message::body_buffer();
      payload.reserve(payload.size() + sizes[owner]);
    }
    move_part(region, payload);
    RegionCounts& counts = counts_[std::size_t(region)];
    encoded.splats[owner] += counts.splats;
    for (const auto bits : counts.passes) encoded.passes[owner] += std::uint32_t(std::popcount(bits));
    counts = {};
  }
  used_.clear();
  return encoded;
}

void SliceEncoder::take_opaque_news(std::span<const std::byte> news) {
  if (news.empty()) return;
  read_opaque_news(news, opaque_);
  for (std::size_t region = 0; region < covers_.size(); ++region)
    if (covers_[region].opaque() != opaque_[region].opaque()) covers_[region].update(opaque_[region]);
}

std::unique_ptr<Encoder> make_encoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers,
                                      EmptySpace& empty_space) {
  const auto make = spec.payload == PayloadForm::words ? make_word_encoder : make_run_encoder;
  return make(spec, geometry, renderers, empty_space);
}

}  // namespace ringsplat
