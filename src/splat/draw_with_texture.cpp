#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/draw_with_texture.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>

#include "splat/painter_kernels.hpp"
#include "splat/splat_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

#if RINGSPLAT_ONE_BY_ONE

class TextureAdder {
 public:
  /// Adds to `count` pixels.
  void add(float* pixels, const float* weights, const Colour& colour, int count) const {
    for (int i = 0; i < count; ++i) add_to(pixels + 4 * i, weights[i], colour);
  }
};

#else

class TextureAdder {
 public:
  // An implicit constructor would be compiled without the target's instructions.
  HWY_INLINE TextureAdder() {}
  /// Adds to `count` pixels; up to the end of the last vector zeros are added.
  HWY_INLINE void add(float* pixels, const float* weights, const Colour& colour, int count) const {
    const Floats d;
    for (int left = count; left > 0; left -= int(pixels_a_vector)) {
      const auto inside = hn::FirstN(d, std::min(std::size_t(left), pixels_a_vector));
      add_to(pixels, spread_.get<0>(hn::IfThenElseZero(inside, hn::LoadU(d, weights))), colour);
      pixels += lanes;
      weights += pixels_a_vector;
    }
  }

 private:
  Spread spread_;
};

#endif

class TexturePainter {
 public:
  HWY_INLINE TexturePainter(const SliceBuffer& slice, const FootprintTable& table, PixelRun* written)
      : slice_(slice), table_(table), written_(written) {}

  HWY_INLINE DrawCounts draw(const SplatRun& run) const {
    DrawCounts counts;
    for (std::size_t i = 0; i < run.count; ++i) {
      const Splat splat = load_splat(run.bytes + i * sizeof(Splat));
      if (is_plausible(splat) && draw_one(splat, run.base_x + splat.anchor_x, run.base_y + splat.anchor_y))
        ++counts.drawn;
    }
    counts.clipped = run.count - counts.drawn;
    return counts;
  }

 private:
  HWY_INLINE bool draw_one(const Splat& splat, std::int64_t x, std::int64_t y) const {
    const std::int64_t left = -x, right = slice_.width - x, top = std::max(-y, -table_.reach_y),
                       bottom = std::min(slice_.height - 1 - y, table_.reach_y + 1);
    if (left > table_.reach_x + 1 || right <= -table_.reach_x) return false;
    const Colour colour = load_colour(splat);
    const std::size_t first_row = table_.phase_of(splat.a, splat.b) * table_.rows();
    bool reached = false;
    for (std::int64_t dy = top; dy <= bottom; ++dy) {
      const std::size_t at = first_row + static_cast<std::size_t>(dy + table_.reach_y);
      const PixelRun& covered = table_.covered[at];
      const auto first = std::max<std::int64_t>(covered.first, left),
                 end = std::min<std::int64_t>(covered.end, right);
      if (first >= end) continue;
      reached = true;
      const auto row = static_cast<std::ptrdiff_t>(y + dy);
      written_[row].include(static_cast<std::int32_t>(x + first), static_cast<std::int32_t>(x + end));
      adder_.add(slice_.origin + row * slice_.row_floats + (x + first) * 4,
                 table_.weights.data() + at * table_.row + (first + table_.reach_x), colour,
                 static_cast<int>(end - first));
    }
    return reached;
  }

  const SliceBuffer& slice_;
  const FootprintTable& table_;
  PixelRun* written_;
  TextureAdder adder_;
};

DrawCounts DrawWithTexture(const SliceBuffer& slice, const FootprintTable& table, const SplatRun& run,
                           PixelRun* written) {
  return TexturePainter(slice, table, written).draw(run);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(DrawWithTexture);

namespace {

constexpr std::size_t most_floats = std::size_t{4} << 20;
constexpr std::size_t widest_vector = 16;  ///< floats

void fill_row(const Footprint& footprint, std::int64_t reach_x, double y, double centre_x, float* weights,
              PixelRun& covered) {
  for (std::int64_t x = -reach_x; x <= reach_x + 1; ++x) {
    const double dx = static_cast<double>(x) - centre_x;
    const double q = 1 + footprint.d * dx * dx + footprint.e * dx * y + footprint.f * y * y;
    if (!(q > 0)) continue;
    weights[x + reach_x] = static_cast<float>(q * q);
    const auto at = static_cast<std::int32_t>(x);
    covered.include(at, at + 1);
  }
}

}  // namespace

std::size_t FootprintTable::phase_of(float a, float b) const {
  const auto nearest = [&](double centre) {
    return static_cast<std::size_t>(std::clamp(centre * phases, 0.0, phases - 0.5));
  };
  const auto fa = static_cast<double>(a), fb = static_cast<double>(b);
  return nearest(y_of_a * fa + y_of_b * fb) * static_cast<std::size_t>(phases) +
         nearest(x_of_a * fa + x_of_b * fb);
}

FootprintTable make_footprint_table(const Footprint& footprint, int phases) {
  const auto reach = kernel_reach(footprint);
  FootprintTable table;
  table.reach_x = reach.x;
  table.reach_y = reach.y;
  table.row = static_cast<std::size_t>(2 * reach.x + 2) + widest_vector;
  while (phases > 1 &&
         static_cast<std::size_t>(phases) * static_cast<std::size_t>(phases) * table.rows() * table.row >
             most_floats)
    --phases;
  table.phases = phases;

  const double determinant = 4 * footprint.d * footprint.f - footprint.e * footprint.e;
  table.x_of_a = -2 * footprint.f / determinant;
  table.x_of_b = table.y_of_a = footprint.e / determinant;
  table.y_of_b = -2 * footprint.d / determinant;

  const std::size_t all = static_cast<std::size_t>(phases) * static_cast<std::size_t>(phases);
  table.weights.assign(all * table.rows() * table.row, 0.0F);
  table.covered.resize(all * table.rows());
  std::size_t at = 0;
  for (int j = 0; j < phases; ++j)
    for (int i = 0; i < phases; ++i)
      for (std::int64_t y = -reach.y; y <= reach.y + 1; ++y, ++at)
        fill_row(footprint, reach.x, static_cast<double>(y) - (j + 0.5) / phases, (i + 0.5) / phases,
                 table.weights.data() + at * table.row, table.covered[at]);
  return table;
}

DrawCounts draw_with_texture(const SliceBuffer& slice, const FootprintTable& table, const SplatRun& run,
                             PixelRun* written) {
  return HWY_DYNAMIC_DISPATCH(DrawWithTexture)(slice, table, run, written);
}

}  // namespace ringsplat
#endif
