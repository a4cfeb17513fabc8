#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/draw_with_texture.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>

#include "splat/footprint_table.hpp"
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

DrawCounts draw_with_texture(const SliceBuffer& slice, const FootprintTable& table, const SplatRun& run,
                             PixelRun* written) {
  return HWY_DYNAMIC_DISPATCH(DrawWithTexture)(slice, table, run, written);
}

}  // namespace ringsplat
#endif
