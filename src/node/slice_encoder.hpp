#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "node/opaque_cover.hpp"
#include "node/row_classifier.hpp"
#include "ringsplat/node/engine.hpp"
#include "ringsplat/splat/encode.hpp"
#include "ringsplat/splat/opaque_tiles.hpp"
#include "ringsplat/view/slice_dda.hpp"

namespace ringsplat {

/// Which passes of a (region, slice) have a splat, a bit each (Neumann 1992, Fig. 3): for each row offset, by
/// column offset.
using PassBits = std::array<std::uint16_t, 16>;

/// What the paper's payload and runs of voxels have in common: rows are classified, and each region's part of
/// the slice is gathered by itself and then handed to the Renderer that owns the region.
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

  /// Counts splats of a region, of this row's voxels in columns first … first + splats − 1; its part becomes
  /// one of the slice's payloads.
  void count_run(int region, int first, int splats) {
    RegionCounts& counts = counts_[std::size_t(region)];
    if (counts.splats == 0) used_.push_back(region);
    counts.splats += std::uint32_t(splats);
    std::uint16_t& passes = counts.passes[std::size_t(row_offset_)];
    if (passes != all_columns())
      passes |= std::uint16_t(splats < stride_ ? few_columns(first % stride_, splats) : all_columns());
  }
  bool used(int region) const { return counts_[std::size_t(region)].splats > 0; }
  /// True when the pixels (inclusive, on the screen) inside the region are opaque, as far as is known here.
  bool hidden(int region, const PixelWindow& window) const {
    if (!cover(region).worth_asking()) return false;
    const PixelRect& pixels = rect(region);
    return opaque_[std::size_t(region)].hides(window.x0 - pixels.x0, window.y0 - pixels.y0,
                                              window.x1 - pixels.x0, window.y1 - pixels.y0);
  }
  const OpaqueCover& cover(int region) const { return covers_[std::size_t(region)]; }
  const PixelRect& rect(int region) const { return rects_[std::size_t(region)]; }

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
  unsigned all_columns() const { return (1U << stride_) - 1; }
  /// Offsets of consecutive columns, fewer than a stride, the first of which has offset `first`.
  unsigned few_columns(int first, int columns) const {
    const unsigned bits = ((1U << columns) - 1) << first;
    return (bits | bits >> stride_) & all_columns();
  }

  const FrameSpec& spec_;
  EmptySpace& empty_space_;
  int renderers_;
  int stride_;
  std::vector<RegionCounts> counts_;  ///< by region
  std::vector<PixelRect> rects_;      ///< by region
  std::vector<int> used_;             ///< regions with splats in this slice
  std::vector<OpaqueTiles> opaque_;   ///< by region
  std::vector<OpaqueCover> covers_;   ///< of them
  int row_ = 0, row_offset_ = 0;      ///< within the stride
  std::uint64_t visible_ = 0;
  StageSeconds* stages_ = nullptr;
};

std::unique_ptr<Encoder> make_word_encoder(const FrameSpec& spec, const FrameGeometry& geometry,
                                           int renderers, EmptySpace& empty_space);
std::unique_ptr<Encoder> make_run_encoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers,
                                          EmptySpace& empty_space);

}  // namespace ringsplat
