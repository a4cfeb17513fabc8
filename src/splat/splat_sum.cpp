#include "splat/splat_sum.hpp"

#include <cstring>

#include "raster/composite_row.hpp"
#include "splat/encode.hpp"
#include "splat/splat_adder.hpp"

namespace ringsplat {

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
