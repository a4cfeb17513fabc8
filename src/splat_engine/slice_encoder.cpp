#include <algorithm>
#include <bit>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "classify/empty_space.hpp"
#include "engine_parts/frame_engine.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "splat_engine/row_band.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {
namespace {

/// Encodes slices in bands of rows, one for each thread. Payloads join the bands' parts in the order of rows,
/// so their bytes do not depend on the number of bands.
class SliceEncoder final : public FrameEncoder<SplatFrame> {
 public:
  SliceEncoder(std::shared_ptr<const SplatFrame> frame, int renderers, const SliceStore& store,
               EmptySpace& empty_space, ThreadTeam& threads, bool skip_empty)
      : FrameEncoder(std::move(frame), store),
        empty_space_(empty_space),
        threads_(threads),
        skip_empty_(skip_empty),
        renderers_(renderers),
        last_bytes_(std::size_t(renderers)) {
    if (frame_->shown.shading == Shading::phong && !store_.has_normals())
      throw RunError(fmt::format("frame {} is shaded, but no normals were loaded", frame_->number),
                     "load them with --shading phong");
    if (frame_->shown.shading == Shading::phong && store_.normals_within() != geometry().box)
      throw RunError(
          fmt::format("frame {} is lit within another clip box than its splats' normals were made for",
                      frame_->number),
          "load the volume with this clip box, or draw sheets, whose gradients are made frame by frame");
  }

  std::vector<int> shown() override {
    // Of the whole volume, other GPs' too.
    std::vector<bool> may_show(std::size_t(store_.grid().slices(axis())), true);
    if (skip_empty_)
      for (const SliceRange& range : store_.ranges(axis()))
        may_show[std::size_t(range.slice)] =
            frame_->shown.transfer_function.visible_within(range.low, range.high);
    const int first = geometry().box.first[static_cast<int>(axis())];
    std::vector<int> steps;
    for (int step = 0; step < geometry().slices; ++step)
      if (may_show[std::size_t(first + geometry().slice_at(step))]) steps.push_back(step);
    return steps;
  }

  void begin(int step) override {
    if (!shared_) shared_.emplace(*frame_);
    const SliceView slice = this->slice(step);
    voxels_ = std::uint64_t(slice.width) * std::uint64_t(slice.height);
    VisibleVoxels& visible = empty_space_.voxels(slice, frame_->shown.transfer_function, geometry().box);
    const std::vector<int> bounds = row_bounds(visible.runs(), slice.height, threads_.size());
    bands_in_use_ = bounds.size() - 1;
    while (bands_.size() < bands_in_use_) bands_.emplace_back(*shared_);
    complete_.assign(bands_in_use_, 0);
    for (std::size_t k = 0; k < bands_in_use_; ++k) bands_[k].begin(slice, visible, bounds[k], bounds[k + 1]);
  }

  bool work() override {
    // A piece of a band is limited by its cost: visible voxels, or many transparent ones. Messages wait for
    // the end of a piece, and so do the other threads.
    const int pieces_at_once = bands_in_use_ > 1 ? 4 : 1;
    threads_.run(int(bands_in_use_), [this, pieces_at_once](int band) {
      char& complete = complete_[std::size_t(band)];
      if (!complete) complete = bands_[std::size_t(band)].work(1024 * pieces_at_once, 16384 * pieces_at_once);
    });
    return std::all_of(complete_.begin(), complete_.end(), [](char complete) { return complete; });
  }

  EncodedStep finish() override {
    EncodedStep encoded;
    encoded.parts.resize(std::size_t(renderers_));
    encoded.counts.voxels = voxels_;
    for (const RowBand& band : bands()) {
      encoded.counts.visible += band.visible_voxels();
      encoded.counts.outside += band.voxels_outside();
    }
    for (const int region : used_regions()) {
      const auto owner = std::size_t(drawer_of(region));
      EncodedPart& part = encoded.parts[owner];
      if (part.payload.empty()) {
        part.payload = Message::body_buffer();
        part.payload.reserve(last_bytes_[owner]);
      }
      RowBand::append_parts(region, bands(), part.payload);
      const RegionCounts counts = counts_of(region);
      part.items += counts.splats;
      for (const auto bits : counts.passes) part.passes += std::uint32_t(std::popcount(bits));
      part.tiles.push_back(region);
    }
    for (std::size_t k = 0; k < last_bytes_.size(); ++k)
      last_bytes_[k] = std::max(encoded.parts[k].payload.size(), last_bytes_[k] / 2);
    for (RowBand& band : bands()) band.clear_counts();
    return encoded;
  }

  void take_news(std::span<const std::byte> news) override {
    if (shared_) read_opaque_news(news, shared_->opaque);
  }

 private:
  std::span<RowBand> bands() { return std::span(bands_).first(bands_in_use_); }

  /// Ascending, the order in payloads.
  std::vector<int> used_regions() {
    std::vector<int> regions;
    for (const RowBand& band : bands())
      regions.insert(regions.end(), band.used_regions().begin(), band.used_regions().end());
    std::sort(regions.begin(), regions.end());
    regions.erase(std::unique(regions.begin(), regions.end()), regions.end());
    return regions;
  }

  /// Sum over bands; a pass with splats in several bands counts once.
  RegionCounts counts_of(int region) {
    RegionCounts sum;
    for (const RowBand& band : bands()) {
      const RegionCounts& counts = band.counts(region);
      sum.splats += counts.splats;
      for (std::size_t k = 0; k < sum.passes.size(); ++k)
        sum.passes[k] = std::uint16_t(sum.passes[k] | counts.passes[k]);
    }
    return sum;
  }

  EmptySpace& empty_space_;
  ThreadTeam& threads_;
  bool skip_empty_;
  int renderers_;
  std::vector<std::size_t> last_bytes_;  ///< by Renderer: about as many as its last payload had
  std::optional<EncoderFrame> shared_;   ///< made for the first slice: a GP may have none
  std::uint64_t voxels_ = 0;             ///< of the slice
  std::vector<RowBand> bands_;
  std::size_t bands_in_use_ = 0;  ///< how many bands the slice uses, in the order of its rows
  std::vector<char> complete_;    ///< by band in use; each is written by one thread
};

}  // namespace

std::unique_ptr<Encoder> make_splat_encoder(std::shared_ptr<const SplatFrame> frame, int renderers,
                                            const SliceStore& store, EmptySpace& empty_space,
                                            ThreadTeam& threads, bool skip_empty) {
  return std::make_unique<SliceEncoder>(std::move(frame), renderers, store, empty_space, threads, skip_empty);
}

}  // namespace ringsplat
