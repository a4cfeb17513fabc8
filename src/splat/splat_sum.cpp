#include "splat/splat_sum.hpp"

#include <ranges>

namespace ringsplat {
namespace {

constexpr float never = -1e30F;

double form(const Footprint& footprint, double x, double y) {
  return footprint.d * x * x + footprint.e * x * y + footprint.f * y * y;
}

/// Largest Q that a kernel can have `x` pixels right of its anchor and `y` below it, over all centres in the
/// unit square. For pixels outside the square the concave form is largest on the square's border.
double largest_q(const Footprint& footprint, double x, double y) {
  if (x >= 0 && x <= 1 && y >= 0 && y <= 1) return 1;
  double best = -1e300;
  for (const double side : {0.0, 1.0}) {
    const double u = x - side, v = y - side;
    const double along_y = std::clamp(-footprint.e * u / (2 * footprint.f), y - 1, y);
    const double along_x = std::clamp(-footprint.e * v / (2 * footprint.d), x - 1, x);
    best = std::max({best, form(footprint, u, along_y), form(footprint, along_x, v)});
  }
  return 1 + best;
}

bool has_stencil(const Footprint& footprint) {
  const auto reach = kernel_reach(footprint);
  return 2 * std::max(reach.x, reach.y) + 2 <= largest_stencil_window;
}

}  // namespace

Stencil make_stencil(const Footprint& footprint, std::ptrdiff_t row_floats) {
  const auto reach = kernel_reach(footprint);
  Stencil stencil;
  stencil.reach_x = int(reach.x);
  stencil.reach_y = int(reach.y);

  constexpr double rounding = 1e-4;
  std::vector<glm::ivec2> blocks;  // the first pixels of those that can be drawn
  for (int y = -stencil.reach_y; y <= stencil.reach_y + 1; ++y)
    for (int x = -stencil.reach_x; x <= stencil.reach_x + 1; x += block_pixels) {
      const auto can_be_drawn = [&](int i) { return largest_q(footprint, x + i, y) > -rounding; };
      if (std::ranges::any_of(std::views::iota(0, block_pixels), can_be_drawn)) blocks.emplace_back(x, y);
    }
  const std::size_t real = blocks.size();
  while (blocks.size() % 4 != 0) blocks.push_back(blocks.back());

  stencil.blocks = blocks.size();
  stencil.k = allocate_floats(stencil.blocks * block_pixels);
  stencil.dx = allocate_floats(stencil.blocks * block_pixels);
  stencil.dy = allocate_floats(stencil.blocks * block_pixels);
  for (std::size_t b = 0; b < stencil.blocks; ++b) {
    stencil.offset.push_back(blocks[b].y * row_floats + blocks[b].x * std::ptrdiff_t{4});
    for (int i = 0; i < block_pixels; ++i) {
      const int x = blocks[b].x + i, y = blocks[b].y;
      const bool inside = b < real && x <= stencil.reach_x + 1;
      const std::size_t at = b * block_pixels + std::size_t(i);
      stencil.k[at] = inside ? float(form(footprint, x, y)) : never;
      stencil.dx[at] = float(x);
      stencil.dy[at] = float(y);
    }
  }
  return stencil;
}

SplatSum::SplatSum(const Footprint& footprint, const PixelRect& largest)
    : reach_(kernel_reach(footprint)), footprint_(footprint) {
  const bool by_anchors = has_stencil(footprint);
  // With a stencil splats are added without clipping, and zeros go to the margins. Without it rows are
  // clipped to the region, but for the rest of the last vector.
  buffer_ = make_slice_buffer(by_anchors ? window_margins(reach_) : Margins{0, 16, 0, 0}, largest);
  if (by_anchors) stencil_ = make_stencil(footprint, buffer_.row_floats);
  runs_.resize(std::size_t(largest.height() + (by_anchors ? 2 * reach_.y + 1 : 0)));
}

DrawCounts SplatSum::draw(std::span<const Splat> splats) {
  const auto visible = image_->opaque_tiles().worth_asking() ? without_hidden(splats) : splats;
  DrawCounts counts = draw_splats(buffer_, footprint_, stencil_ ? &*stencil_ : nullptr, visible,
                                  image_->rect().x0, image_->rect().y0, runs_.data());
  counts.hidden = splats.size() - visible.size();
  if (counts.drawn > 0) empty_ = false;
  return counts;
}

/// The splats that are not wholly under opaque tiles, in seen_.
std::span<const Splat> SplatSum::without_hidden(std::span<const Splat> splats) {
  const OpaqueTiles& tiles = image_->opaque_tiles();
  seen_.resize(splats.size());
  std::size_t kept = 0;
  for (const Splat& splat : splats) {
    const PixelWindow window =
        pixel_window({splat.anchor_x - image_->rect().x0, splat.anchor_y - image_->rect().y0, 0, 0}, reach_);
    // Every splat is written and only those that are seen are kept: no branch to mispredict.
    seen_[kept] = splat;
    kept += tiles.hides(window.x0, window.y0, window.x1, window.y1) ? 0 : 1;
  }
  return std::span(seen_).first(kept);
}

std::span<const PixelRun> SplatSum::written() {
  if (!stencil_) return std::span(runs_).first(std::size_t(buffer_.height));
  // The pixels that the anchors' windows cover inside the region.
  written_.assign(std::size_t(buffer_.height), PixelRun{});
  const int reach_x = int(reach_.x), reach_y = int(reach_.y);
  for (int i = 0; i < int(runs_.size()); ++i) {
    const PixelRun& anchors = runs_[std::size_t(i)];
    if (anchors.empty()) continue;
    const int row = i - reach_y - 1;
    const int first = std::max(anchors.first - reach_x, 0),
              end = std::min(anchors.end + reach_x + 1, buffer_.width);
    for (int y = std::max(row - reach_y, 0); y <= std::min(row + reach_y + 1, buffer_.height - 1); ++y)
      written_[std::size_t(y)].include(first, end);
  }
  return written_;
}

std::uint64_t SplatSum::composite() {
  std::uint64_t composited = 0;
  if (!empty_) {
    float* image = image_->pixels();
    const auto rows = written();
    for (int y = 0; y < buffer_.height; ++y) {
      const PixelRun& run = rows[std::size_t(y)];
      if (run.empty()) continue;
      const int first = run.first / block_pixels * block_pixels;
      const auto pixels = std::size_t(in_whole_blocks(run.end) - first);
      float* sums = buffer_.origin + y * buffer_.row_floats + first * floats_a_pixel;
      composite_row(sums, image + y * image_->row_floats() + first * floats_a_pixel, pixels * floats_a_pixel,
                    image_->opaque_threshold());
      composited += pixels;
    }
    image_->slices_composited();
    empty_ = true;
  }
  std::fill(runs_.begin(), runs_.end(), PixelRun{});
  return composited;
}

}  // namespace ringsplat
