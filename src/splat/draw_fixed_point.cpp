#include <algorithm>
#include <cmath>
#include <cstring>

#include "splat/painter_kernels.hpp"
#include "splat/splat.hpp"

namespace ringsplat {

namespace {

constexpr int guard_bits = 14;
/// No footprint has larger coefficients, since its semi-axes are a pixel or more.
constexpr float largest_a_or_b = 4.5F, largest_c = 8;

bool is_plausible(const Splat& splat) {
  return std::abs(splat.a) <= largest_a_or_b && std::abs(splat.b) <= largest_a_or_b &&
         std::abs(splat.c) <= largest_c && std::abs(splat.opacity) < largest_coefficient;
}

class FixedPointPainter {
 public:
  FixedPointPainter(const SliceBuffer& slice, const Footprint& footprint, int bits, PixelRun* written)
      : slice_(slice),
        written_(written),
        reach_(kernel_reach(footprint)),
        bits_(bits),
        d_(fixed(footprint.d)),
        e_(fixed(footprint.e)),
        f_(fixed(footprint.f)) {}

  bool draw(const Splat& splat, std::int64_t x, std::int64_t y) const {
    const std::int64_t left = std::max(-x, -reach_.x), right = std::min(slice_.width - 1 - x, reach_.x + 1);
    const std::int64_t top = std::max(-y, -reach_.y), bottom = std::min(slice_.height - 1 - y, reach_.y + 1);
    if (left > right) return false;
    const std::int64_t a = fixed(static_cast<double>(splat.a));
    const float scale = splat.opacity * (1.0F / 65535.0F);
    const float colour[4] = {static_cast<float>(splat.red) * scale, static_cast<float>(splat.green) * scale,
                             static_cast<float>(splat.blue) * scale, splat.opacity};
    bool reached = false;
    for (std::int64_t dy = top; dy <= bottom; ++dy) {
      const std::int64_t row = row_of(splat, dy);
      float* pixel = slice_.origin + (y + dy) * slice_.row_floats + (x + left) * 4;
      for (std::int64_t dx = left; dx <= right; ++dx, pixel += 4) {
        const float weight = weight_of(a, row, dx, dy);
        if (weight == 0) continue;
        for (int c = 0; c < 4; ++c) pixel[c] = pixel[c] + weight * colour[c];
        const auto at = static_cast<std::int32_t>(x + dx);
        written_[y + dy].include(at, at + 1);
        reached = true;
      }
    }
    return reached;
  }

 private:
  std::int64_t fixed(double value) const { return std::llround(std::ldexp(value, bits_ + guard_bits)); }
  std::int64_t row_of(const Splat& splat, std::int64_t dy) const {
    return (f_ * dy + fixed(static_cast<double>(splat.b))) * dy + fixed(static_cast<double>(splat.c));
  }
  /// Q², or 0 where Q is not positive.
  float weight_of(std::int64_t a, std::int64_t row, std::int64_t dx, std::int64_t dy) const {
    const std::int64_t q = ((d_ * dx + e_ * dy + a) * dx + row) >> guard_bits;
    if (q <= 0) return 0;
    const std::int64_t largest = (std::int64_t{1} << bits_) - 1;
    const float value = std::ldexp(static_cast<float>(std::min(q, largest)), -bits_);
    return value * value;
  }

  const SliceBuffer& slice_;
  PixelRun* written_;
  KernelReach reach_;
  int bits_;
  std::int64_t d_, e_, f_;
};

}  // namespace

DrawCounts draw_fixed_point(const SliceBuffer& slice, const Footprint& footprint, int bits,
                            const SplatRun& run, PixelRun* written) {
  const FixedPointPainter painter(slice, footprint, bits, written);
  DrawCounts counts;
  for (std::size_t i = 0; i < run.count; ++i) {
    Splat splat;
    std::memcpy(&splat, run.bytes + i * sizeof(Splat), sizeof splat);
    if (is_plausible(splat) && painter.draw(splat, run.base_x + splat.anchor_x, run.base_y + splat.anchor_y))
      ++counts.drawn;
  }
  counts.clipped = run.count - counts.drawn;
  return counts;
}

}  // namespace ringsplat
