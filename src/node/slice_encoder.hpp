#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "node/row_classifier.hpp"
#include "ringsplat/node/engine.hpp"
#include "ringsplat/splat/encode.hpp"
#include "ringsplat/splat/opaque_tiles.hpp"
#include "ringsplat/view/slice_dda.hpp"

namespace ringsplat {

/// Which passes of a (region, slice) have a splat, a bit each (Neumann 1992, Fig. 3).
using PassBits = std::array<std::uint64_t, 4>;

/// What the paper's payload and runs of voxels have in common: rows are classified, and each region's part of the slice is
/// gathered by itself and then handed to the Renderer that owns the region.
class SliceEncoder : public Encoder {
 public:
  SliceEncoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers, EmptySpace& empty_space);
  void begin(const SliceView& slice) override;
  bool work() override;
  EncodedSlice finish() override;
  void take_opaque_news(std::span<const std::byte> news) override;
  void time_stages(StageSeconds* stages) override { stages_ = stages; }

 protected:
  /// Puts the row's visible voxels into their regions' parts.
  virtual void encode_row(int row) = 0;
  /// Appends a used region's part to its Renderer's payload and empties it.
  virtual void move_part(int region, Bytes& payload) = 0;
  virtual std::size_t part_bytes(int region) const = 0;

  /// Counts splats of a region, of voxels in columns first … first + splats − 1; its part becomes one of the slice's payloads.
  void count_run(int region, int first, int splats, int row) {
    RegionCounts& counts = counts_[std::size_t(region)];
    if (counts.splats == 0) used_.push_back(region);
    counts.splats += std::uint32_t(splats);
    const int row_passes = stride_ * (row % stride_);
    for (int k = 0, column = first % stride_; k < std::min(splats, stride_); ++k, column = column + 1 == stride_ ? 0 : column + 1) {
      const auto pass = std::size_t(row_passes + column);
      counts.passes[pass / 64] |= std::uint64_t{1} << (pass % 64);
    }
  }
  bool used(int region) const { return counts_[std::size_t(region)].splats > 0; }
  /// True when the pixels (inclusive, on the screen) inside the region are opaque, as far as is known here.
  bool hidden(int region, const PixelWindow& window) const {
    const OpaqueTiles& tiles = opaque_[std::size_t(region)];
    if (!tiles.worth_asking()) return false;
    const PixelRect rect = geometry_.regions.rect(region);
    return tiles.hides(window.x0 - rect.x0, window.y0 - rect.y0, window.x1 - rect.x0, window.y1 - rect.y0);
  }
  bool knows_opaque(int region) const { return opaque_[std::size_t(region)].worth_asking(); }

  const FrameGeometry& geometry_;
  RowClassifier rows_;
  SliceDda dda_;
  KernelReach reach_;

 private:
  struct RegionCounts {
    std::uint32_t splats = 0;
    PassBits passes{};
  };

  int classify_row();

  const FrameSpec& spec_;
  EmptySpace& empty_space_;
  int renderers_;
  int stride_;
  std::vector<RegionCounts> counts_;  ///< by region
  std::vector<int> used_;             ///< regions with splats in this slice
  std::vector<OpaqueTiles> opaque_;   ///< by region
  int row_ = 0;
  std::uint64_t visible_ = 0;
  StageSeconds* stages_ = nullptr;
};

std::unique_ptr<Encoder> make_word_encoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers,
                                           EmptySpace& empty_space);
std::unique_ptr<Encoder> make_run_encoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers,
                                          EmptySpace& empty_space);

}  // namespace ringsplat
