#include "splat/stencil.hpp"

#include <algorithm>
#include <ranges>

#include "splat/splat.hpp"

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

}  // namespace

float quadratic_part(const Footprint& footprint, int x, int y) {
  return static_cast<float>(form(footprint, x, y));
}

bool has_stencil(const Footprint& footprint) {
  const auto reach = kernel_reach(footprint);
  return 2 * std::max(reach.x, reach.y) + 2 <= largest_stencil_window;
}

Stencil make_stencil(const Footprint& footprint, std::ptrdiff_t row_floats) {
  const auto reach = kernel_reach(footprint);
  Stencil stencil;
  stencil.reach_x = static_cast<int>(reach.x);
  stencil.reach_y = static_cast<int>(reach.y);

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
      const std::size_t at = b * block_pixels + static_cast<std::size_t>(i);
      stencil.k[at] = inside ? quadratic_part(footprint, x, y) : never;
      stencil.dx[at] = static_cast<float>(x);
      stencil.dy[at] = static_cast<float>(y);
    }
  }
  return stencil;
}

}  // namespace ringsplat
