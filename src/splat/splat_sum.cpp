#include "splat/splat_sum.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "splat/frame_kernel.hpp"
#include "splat/painter_kernels.hpp"
#include "splat/slice_sum.hpp"
#include "splat/splat.hpp"
#include "splat/stencil.hpp"

namespace ringsplat {

/// Adds splats to a slice buffer by a frame's kernel, and keeps account of the pixels it wrote.
class SplatAdder {
 public:
  virtual ~SplatAdder() = default;
  virtual Margins margins() const = 0;
  /// Call once, with a buffer that has the margins round the largest region.
  virtual void prepare(const SliceBuffer& largest) = 0;
  /// `slice`: a region that is no larger, with rows of the same length.
  virtual DrawCounts add(const SliceBuffer& slice, const SplatRun& run) = 0;
  /// Each of the region's rows: a run of pixels outside which nothing was written since forget().
  virtual std::span<const PixelRun> written(const SliceBuffer& slice) = 0;
  virtual void forget() = 0;
};

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
class RowAdder final : public SplatAdder {
 public:
  using Draw = std::function<DrawCounts(const SliceBuffer& slice, const SplatRun& run, PixelRun* written)>;
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

RowAdder::Draw draw_with(const Footprint& of, const RowWeights&) {
  return [of](const auto& slice, const auto& run, PixelRun* written) {
    return draw_by_rows(slice, of, run, written);
  };
}
RowAdder::Draw draw_with(const Footprint& of, const FixedPointWeights& weights) {
  return [of, bits = weights.bits](const auto& slice, const auto& run, PixelRun* written) {
    return draw_fixed_point(slice, of, bits, run, written);
  };
}
RowAdder::Draw draw_with(const Footprint&, const TabledWeights& weights) {
  return [table = weights.table](const auto& slice, const auto& run, PixelRun* written) {
    return draw_with_texture(slice, *table, run, written);
  };
}

std::unique_ptr<SplatAdder> make_splat_adder(const FrameKernel& kernel) {
  const auto make = [&kernel](const auto& weights) -> std::unique_ptr<SplatAdder> {
    if constexpr (std::is_same_v<decltype(weights), const StencilWeights&>)
      return std::make_unique<StencilAdder>(kernel.footprint);
    else
      return std::make_unique<RowAdder>(draw_with(kernel.footprint, weights));
  };
  return std::visit(make, kernel.weights);
}

}  // namespace

SplatSum::SplatSum(const FrameKernel& kernel, RegionSize largest, SliceBufferMemory& memory)
    : reach_(kernel_reach(kernel.footprint)),
      lattice_sum_(kernel.lattice_sum),
      adder_(make_splat_adder(kernel)),
      memory_(memory) {
  buffer_ = make_slice_buffer(adder_->margins(), largest, memory_);
  adder_->prepare(buffer_);
}

SplatSum::~SplatSum() {
  if (!empty_) memory_.discard();
}

void SplatSum::begin(RegionImage& image) {
  image_ = &image;
  buffer_.width = image.rect().width();
  buffer_.height = image.rect().height();
}

DrawCounts SplatSum::draw(std::int32_t base_x, std::int32_t base_y, std::span<const std::byte> splats) {
  if (splats.size() < sizeof(Splat)) return {};
  const std::int64_t left = std::int64_t{base_x} - image_->rect().x0,
                     top = std::int64_t{base_y} - image_->rect().y0;
  const auto visible = image_->opaque_tiles().worth_asking() ? without_hidden(left, top, splats) : splats;
  DrawCounts counts = adder_->add(buffer_, {visible.data(), visible.size() / sizeof(Splat), left, top});
  counts.hidden = (splats.size() - visible.size()) / sizeof(Splat);
  if (counts.drawn > 0) empty_ = false;
  return counts;
}

/// The splats that are not wholly under opaque tiles, in seen_.
std::span<const std::byte> SplatSum::without_hidden(std::int64_t left, std::int64_t top,
                                                    std::span<const std::byte> splats) {
  const OpaqueTiles& tiles = image_->opaque_tiles();
  seen_.resize(splats.size());
  std::size_t kept = 0;
  for (std::size_t at = 0; at + sizeof(Splat) <= splats.size(); at += sizeof(Splat)) {
    Splat splat;
    std::memcpy(&splat, splats.data() + at, sizeof splat);
    const PixelWindow window = pixel_window({left + splat.anchor_x, top + splat.anchor_y, 0, 0}, reach_);
    // Every splat is written and only those that are seen are kept: no branch to mispredict.
    std::memcpy(seen_.data() + kept, &splat, sizeof splat);
    kept += tiles.hides(window.x0, window.y0, window.x1, window.y1) ? 0 : sizeof splat;
  }
  return std::span<const std::byte>(seen_).first(kept);
}

std::uint64_t SplatSum::composite(glm::dvec2 voxel) {
  std::uint64_t composited = 0;
  if (!empty_) {
    float* image = image_->pixels();
    const auto written = adder_->written(buffer_);
    for (int y = 0; y < buffer_.height; ++y) {
      const PixelRun& run = written[std::size_t(y)];
      if (run.empty()) continue;
      const int first = run.first / block_pixels * block_pixels;
      const auto pixels = std::size_t(in_whole_blocks(run.end) - first);
      float* sums = buffer_.origin + y * buffer_.row_floats + first * floats_a_pixel;
      if (lattice_sum_)
        lattice_sum_->divide_row(sums, pixels, image_->rect().x0 + first, image_->rect().y0 + y, voxel);
      composite_row(sums, image + y * image_->row_floats() + first * floats_a_pixel, pixels * floats_a_pixel,
                    image_->opaque_threshold());
      composited += pixels;
    }
    image_->slices_composited();
    empty_ = true;
  }
  adder_->forget();
  return composited;
}

}  // namespace ringsplat
