#include "splat/splat_adder.hpp"

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "splat/encode.hpp"
#include "splat/stencil.hpp"

namespace ringsplat {
namespace {

/// For kernels whose window is small: splats are added without clipping, and zeros go to the margins.
class StencilAdder final : public SplatAdder {
 public:
  explicit StencilAdder(const Footprint& footprint)
      : footprint_(footprint), reach_(kernel_reach(footprint)) {}

  Margins margins() const override { return window_margins(reach_); }

  void prepare(const SliceBuffer& largest) override {
    stencil_ = make_stencil(footprint_, largest.row_floats);
    anchors_.assign(std::size_t(largest.height + 2 * reach_.y + 1), PixelRun{});
  }

  DrawCounts add(const SliceBuffer& slice, const SplatRun& run) override {
    return draw_with_stencil(slice, stencil_, run, anchors_.data());
  }

  /// The pixels that the anchors' windows cover inside the region.
  std::span<const PixelRun> written(const SliceBuffer& slice) override {
    written_.assign(std::size_t(slice.height), PixelRun{});
    const int reach_x = stencil_.reach_x, reach_y = stencil_.reach_y;
    for (int i = 0; i < int(anchors_.size()); ++i) {
      const PixelRun& anchors = anchors_[std::size_t(i)];
      if (anchors.empty()) continue;
      const int row = i - reach_y - 1;
      const int first = std::max(anchors.first - reach_x, 0),
                end = std::min(anchors.end + reach_x + 1, slice.width);
      for (int y = std::max(row - reach_y, 0); y <= std::min(row + reach_y + 1, slice.height - 1); ++y)
        written_[std::size_t(y)].include(first, end);
    }
    return written_;
  }

  void forget() override { std::fill(anchors_.begin(), anchors_.end(), PixelRun{}); }

 private:
  Footprint footprint_;
  KernelReach reach_;
  Stencil stencil_;
  std::vector<PixelRun> anchors_;  ///< columns of anchors, by their row from −reach_y − 1 on
  std::vector<PixelRun> written_;
};

/// For all others: each splat's rows are clipped to the region, but for the rest of the last vector.
/// `Draw`: (slice, run, written pixels by row) to counts.
template <class Draw>
class RowAdder final : public SplatAdder {
 public:
  explicit RowAdder(Draw draw) : draw_(std::move(draw)) {}
  Margins margins() const override { return {0, 16, 0, 0}; }
  void prepare(const SliceBuffer& largest) override {
    written_.assign(std::size_t(largest.height), PixelRun{});
  }
  DrawCounts add(const SliceBuffer& slice, const SplatRun& run) override {
    return draw_(slice, run, written_.data());
  }
  std::span<const PixelRun> written(const SliceBuffer& slice) override {
    return std::span(written_).first(std::size_t(slice.height));
  }
  void forget() override { std::fill(written_.begin(), written_.end(), PixelRun{}); }

 private:
  Draw draw_;
  std::vector<PixelRun> written_;
};

template <class Draw>
std::unique_ptr<SplatAdder> make_row_adder(Draw draw) {
  return std::make_unique<RowAdder<Draw>>(std::move(draw));
}

struct MakeAdder {
  const Footprint& footprint;

  std::unique_ptr<SplatAdder> operator()(const StencilWeights&) const {
    return std::make_unique<StencilAdder>(footprint);
  }
  std::unique_ptr<SplatAdder> operator()(const RowWeights&) const {
    return make_row_adder([of = footprint](const SliceBuffer& slice, const SplatRun& run, PixelRun* written) {
      return draw_by_rows(slice, of, run, written);
    });
  }
  std::unique_ptr<SplatAdder> operator()(const FixedPointWeights& weights) const {
    return make_row_adder([of = footprint, bits = weights.bits](const SliceBuffer& slice, const SplatRun& run,
                                                                PixelRun* written) {
      return draw_fixed_point(slice, of, bits, run, written);
    });
  }
  std::unique_ptr<SplatAdder> operator()(const TabledWeights& weights) const {
    return make_row_adder(
        [table = weights.table](const SliceBuffer& slice, const SplatRun& run, PixelRun* written) {
          return draw_with_texture(slice, *table, run, written);
        });
  }
};

}  // namespace

std::unique_ptr<SplatAdder> make_splat_adder(const FrameKernel& kernel) {
  return std::visit(MakeAdder{kernel.footprint}, kernel.weights);
}

}  // namespace ringsplat
