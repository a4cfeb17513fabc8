#include <algorithm>
#include <bit>
#include <memory>
#include <vector>

#include "node/row_band.hpp"
#include "node/row_bounds.hpp"
#include "node/wall_share.hpp"
#include "ringsplat/base/clock.hpp"
#include "ringsplat/net/message.hpp"
#include "ringsplat/node/engine.hpp"

namespace ringsplat {
namespace {

/// Encodes slices in bands of rows, one for each thread. Payloads are the bands' parts in the order of the
/// rows, so they do not tell how many bands there were.
class SliceEncoder final : public Encoder {
 public:
  SliceEncoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers, EmptySpace& empty_space,
               ThreadTeam& threads)
      : frame_(spec, geometry),
        empty_space_(empty_space),
        threads_(threads),
        renderers_(renderers),
        owners_(geometry.owners(renderers)) {}

  void begin(const SliceView& slice) override {
    voxels_ = std::uint64_t(slice.width) * std::uint64_t(slice.height);
    VisibleVoxels& visible = empty_space_.voxels(slice, frame_.spec.transfer_function);
    const std::vector<int> bounds = row_bounds(visible.runs(), slice.height, threads_.size());
    bands_in_use_ = bounds.size() - 1;
    while (bands_.size() < bands_in_use_)
      bands_.push_back(frame_.spec.payload == PayloadForm::words ? make_word_band(frame_)
                                                                 : make_run_band(frame_));
    pieces_.assign(bands_in_use_, {});
    for (std::size_t k = 0; k < bands_in_use_; ++k)
      bands_[k]->begin(slice, visible, bounds[k], bounds[k + 1]);
  }

  bool work() override {
    double wall = 0;
    {
      const OptionalSeconds timed(stages_ ? &wall : nullptr);
      threads_.run(int(bands_in_use_), [this](int band) { encode_some(std::size_t(band)); });
    }
    if (stages_) divide(wall);
    return std::all_of(pieces_.begin(), pieces_.end(), [](const Piece& piece) { return piece.complete; });
  }

  EncodedSlice finish() override {
    EncodedSlice encoded;
    encoded.payloads.resize(std::size_t(renderers_));
    encoded.splats.resize(std::size_t(renderers_));
    encoded.passes.resize(std::size_t(renderers_));
    encoded.voxels = voxels_;
    for (const auto& band : bands()) {
      encoded.visible_voxels += band->visible_voxels();
      encoded.voxels_outside += band->voxels_outside();
    }
    const std::vector<int> regions = used_regions();
    const std::vector<std::size_t> sizes = payload_sizes(regions);
    for (const int region : regions) {
      const auto owner = std::size_t(owners_.of(region));
      Bytes& payload = encoded.payloads[owner];
      if (payload.empty()) {
        payload = Message::body_buffer();
        payload.reserve(payload.size() + sizes[owner]);
      }
      bands_.front()->append_parts(region, bands(), payload);
      const RegionCounts counts = counts_of(region);
      encoded.splats[owner] += counts.splats;
      for (const auto bits : counts.passes) encoded.passes[owner] += std::uint32_t(std::popcount(bits));
    }
    for (const auto& band : bands()) band->clear_counts();
    return encoded;
  }

  void take_opaque_news(std::span<const std::byte> news) override { frame_.take_opaque_news(news); }
  void time_stages(StageSeconds* stages) override { stages_ = stages; }

 private:
  /// What a band's last piece of work was. Written by one thread each.
  struct alignas(64) Piece {
    bool complete = false;
    double busy = 0;
    StageSeconds stages;
  };

  /// Bounded by what costs: visible voxels, or many transparent ones. Messages wait for the end of a piece,
  /// and threads that share it for each other.
  void encode_some(std::size_t band) {
    Piece& piece = pieces_[band];
    if (piece.complete) return;
    const int pieces_at_once = bands_in_use_ > 1 ? 4 : 1;
    const OptionalSeconds timed(stages_ ? &piece.busy : nullptr);
    piece.complete =
        bands_[band]->work(1024 * pieces_at_once, 16384 * pieces_at_once, stages_ ? &piece.stages : nullptr);
  }

  void divide(double wall) {
    Piece sum;
    for (Piece& piece : pieces_) {
      sum.busy += std::exchange(piece.busy, 0);
      const StageSeconds stages = std::exchange(piece.stages, {});
      sum.stages.classify += stages.classify;
      sum.stages.shade += stages.shade;
    }
    stages_->classify += wall_share(wall, sum.stages.classify, sum.busy);
    stages_->shade += wall_share(wall, sum.stages.shade, sum.busy);
  }

  std::span<const std::unique_ptr<RowBand>> bands() const { return std::span(bands_).first(bands_in_use_); }

  /// Ascending, as payloads have them.
  std::vector<int> used_regions() const {
    std::vector<int> regions;
    for (const auto& band : bands())
      regions.insert(regions.end(), band->used_regions().begin(), band->used_regions().end());
    std::sort(regions.begin(), regions.end());
    regions.erase(std::unique(regions.begin(), regions.end()), regions.end());
    return regions;
  }

  std::vector<std::size_t> payload_sizes(std::span<const int> regions) const {
    std::vector<std::size_t> sizes(std::size_t(renderers_), 0);
    for (const int region : regions)
      for (const auto& band : bands()) sizes[std::size_t(owners_.of(region))] += band->part_bytes(region);
    return sizes;
  }

  /// A pass that has splats in several bands is one pass.
  RegionCounts counts_of(int region) const {
    RegionCounts sum;
    for (const auto& band : bands()) {
      const RegionCounts& counts = band->counts(region);
      sum.splats += counts.splats;
      for (std::size_t k = 0; k < sum.passes.size(); ++k)
        sum.passes[k] = std::uint16_t(sum.passes[k] | counts.passes[k]);
    }
    return sum;
  }

  EncoderFrame frame_;
  EmptySpace& empty_space_;
  ThreadTeam& threads_;
  int renderers_;
  RegionOwners owners_;
  std::uint64_t voxels_ = 0;  ///< of the slice
  std::vector<std::unique_ptr<RowBand>> bands_;
  std::size_t bands_in_use_ = 0;  ///< by this slice, in the order of its rows
  std::vector<Piece> pieces_;     ///< by band in use
  StageSeconds* stages_ = nullptr;
};

}  // namespace

std::unique_ptr<Encoder> make_encoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers,
                                      EmptySpace& empty_space, ThreadTeam& threads) {
  return std::make_unique<SliceEncoder>(spec, geometry, renderers, empty_space, threads);
}

}  // namespace ringsplat
