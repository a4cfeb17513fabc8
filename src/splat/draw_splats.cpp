#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/draw_splats.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "raster/pixel_vectors-inl.hpp"
#include "splat/painter_kernels.hpp"
#include "splat/splat.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

HWY_INLINE Splat load_splat(const std::byte* bytes) {
  Splat splat;
  std::memcpy(&splat, bytes, sizeof splat);
  return splat;
}

/// Whether a, b, c and the opacity are all numbers that a footprint can give.
HWY_INLINE bool is_plausible(const Splat& splat) {
  const FourFloats d;
  const auto words = hn::LoadU(d, &splat.a);
  return hn::AllTrue(d, hn::Lt(hn::Abs(words), hn::Set(d, largest_coefficient)));
}

/// A splat's, once for each pixel of a vector.
HWY_INLINE Colour load_colour(const Splat& splat) {
  HWY_ALIGN float colour[4];
  hn::Store(premultiply(&splat.red, splat.opacity), FourFloats(), colour);
  return hn::LoadDup128(Floats(), colour);
}

/// Draws all plausible splats: draw_one(splat, x, y) gets the anchor, from the region's corner, and returns
/// whether the kernel reaches a pixel centre of the region.
template <class DrawOne>
HWY_INLINE DrawCounts draw_each(const SplatRun& run, const DrawOne& draw_one) {
  DrawCounts counts;
  for (std::size_t i = 0; i < run.count; ++i) {
    const Splat splat = load_splat(run.bytes + i * sizeof(Splat));
    if (is_plausible(splat) && draw_one(splat, run.base_x + splat.anchor_x, run.base_y + splat.anchor_y))
      ++counts.drawn;
  }
  counts.clipped = run.count - counts.drawn;
  return counts;
}

/// Draws whole stencils, clipped at the region's border.
class StencilPainter {
 public:
  HWY_INLINE StencilPainter(const SliceBuffer& slice, const Stencil& stencil, PixelRun* anchors)
      : slice_(slice), stencil_(stencil), anchors_(anchors) {}

  HWY_INLINE bool operator()(const Splat& splat, std::int64_t x, std::int64_t y) const {
    const int left = stencil_.reach_x, top = stencil_.reach_y;
    if (x < -left - 1 || x >= slice_.width + left || y < -top - 1 || y >= slice_.height + top) return false;
    anchors_[y + top + 1].include(static_cast<int>(x), static_cast<int>(x) + 1);
    return add(splat, static_cast<int>(x), static_cast<int>(y));
  }

 private:
  HWY_INLINE bool add(const Splat& splat, int x, int y) const {
    const Floats d;
    const auto a = hn::Set(d, splat.a), b = hn::Set(d, splat.b), c = hn::Set(d, splat.c);
    const auto left = hn::Set(d, static_cast<float>(-x)), top = hn::Set(d, static_cast<float>(-y)),
               right = hn::Set(d, static_cast<float>(slice_.width - 1 - x)),
               bottom = hn::Set(d, static_cast<float>(slice_.height - 1 - y));
    const Colour colour = load_colour(splat);
    float* anchor = slice_.origin + y * slice_.row_floats + x * std::ptrdiff_t{4};
    auto largest = hn::Zero(d);
    for (std::size_t block = 0; block < stencil_.blocks; block += pixels_a_vector) {
      const std::size_t at = block * block_pixels;
      const auto dx = hn::Load(d, stencil_.dx.get() + at), dy = hn::Load(d, stencil_.dy.get() + at);
      const auto q = hn::Add(fused(a, dx, hn::Load(d, stencil_.k.get() + at)), fused(b, dy, c));
      const auto inside =
          hn::And(hn::And(hn::Ge(dx, left), hn::Le(dx, right)), hn::And(hn::Ge(dy, top), hn::Le(dy, bottom)));
      const auto w = hn::IfThenElseZero(inside, hn::Max(q, hn::Zero(d)));
      largest = hn::Max(largest, w);
      add_blocks(anchor, stencil_.offset.data() + block, hn::Mul(w, w), colour);
    }
    return !hn::AllFalse(d, hn::Gt(largest, hn::Zero(d)));
  }

  /// Adds to four vectors of pixels, whose weights are one vector. A pixel block is 4 / pixels_a_vector
  /// vectors.
  HWY_INLINE void add_blocks(float* anchor, const std::ptrdiff_t* offset, FloatVector weights,
                             const Colour& colour) const {
    constexpr std::size_t a_block = 4 / pixels_a_vector;
    add_to(anchor + offset[0], spread_.get<0>(weights), colour);
    add_to(anchor + offset[1 / a_block] + 1 % a_block * lanes, spread_.get<1>(weights), colour);
    add_to(anchor + offset[2 / a_block] + 2 % a_block * lanes, spread_.get<2>(weights), colour);
    add_to(anchor + offset[3 / a_block] + 3 % a_block * lanes, spread_.get<3>(weights), colour);
  }

  const SliceBuffer& slice_;
  const Stencil& stencil_;
  PixelRun* anchors_;
  Spread spread_;
};

DrawCounts DrawWithStencil(const SliceBuffer& slice, const Stencil& stencil, const SplatRun& run,
                           PixelRun* anchors) {
  return draw_each(run, StencilPainter(slice, stencil, anchors));
}

/// Half-open run of pixels, as offsets from the anchor.
struct OffsetRun {
  std::int64_t first, end;
  bool empty() const { return first >= end; }
};

/// The pixels where the quadratic of the splat's row is positive. There is no NaN: coefficients are finite
/// and D < 0.
OffsetRun positive_extent(const Footprint& footprint, KernelReach reach, const Splat& splat,
                          std::int64_t row) {
  const auto dy = static_cast<double>(row);
  const double b = static_cast<double>(splat.a) + footprint.e * dy;
  const double c = static_cast<double>(splat.c) + static_cast<double>(splat.b) * dy + footprint.f * dy * dy;
  const double discriminant = b * b - 4 * footprint.d * c;
  if (!(discriminant > 0)) return {0, 0};
  const double root = std::sqrt(discriminant), scale = -2 * footprint.d;
  const auto before = -static_cast<double>(reach.x) - 1, after = static_cast<double>(reach.x) + 2;
  return {static_cast<std::int64_t>(std::ceil(std::clamp((b - root) / scale, before, after))),
          static_cast<std::int64_t>(std::floor(std::clamp((b + root) / scale, before, after))) + 1};
}

class RowPainter {
 public:
  HWY_INLINE RowPainter(const SliceBuffer& slice, const Footprint& footprint, PixelRun* written)
      : slice_(slice), written_(written), footprint_(footprint), reach_(kernel_reach(footprint)) {}

  /// Returns whether the splat reaches a pixel.
  HWY_INLINE bool operator()(const Splat& splat, std::int64_t x, std::int64_t y) const {
    const OffsetRun columns{std::max(-x, -reach_.x), std::min(slice_.width - x, reach_.x + 2)};
    const OffsetRun rows{std::max(-y, -reach_.y), std::min(slice_.height - y, reach_.y + 2)};
    if (columns.empty()) return false;

    const Colour colour = load_colour(splat);
    bool reached = false;
    for (std::int64_t dy = rows.first; dy < rows.end; ++dy) {
      OffsetRun extent = positive_extent(footprint_, reach_, splat, dy);
      extent = {std::max(extent.first, columns.first), std::min(extent.end, columns.end)};
      if (extent.empty()) continue;
      const auto row = static_cast<std::ptrdiff_t>(y + dy);
      const auto first = static_cast<std::int32_t>(x + extent.first);
      written_[row].include(first, static_cast<std::int32_t>(x + extent.end));
      float* pixels = slice_.origin + row * slice_.row_floats + first * std::ptrdiff_t{4};
      reached |= add(pixels, splat, dy, colour, extent);
    }
    return reached;
  }

 private:
  /// Adds to a row of the splat's. Returns whether Q > 0 in any of the pixels. `pixels`: the extent's first.
  HWY_INLINE bool add(float* pixels, const Splat& splat, std::int64_t row, const Colour& colour,
                      const OffsetRun& extent) const {
    const Floats d;
    const hn::Rebind<std::int32_t, Floats> d32;
    const auto dy = static_cast<double>(row);
    const auto set = [&](double value) { return hn::Set(d, static_cast<float>(value)); };
    const auto p00 = set(footprint_.p[0][0]), p10 = set(footprint_.p[0][1]),
               u0 = set(footprint_.p[1][0] * dy), v0 = set(footprint_.p[1][1] * dy);
    const auto a = hn::Set(d, splat.a),
               linear = hn::Set(d, std::fma(splat.b, static_cast<float>(dy), splat.c));
    const auto end = hn::Set(d32, static_cast<std::int32_t>(extent.end));
    auto largest = hn::Zero(d);
    for (std::int64_t at = extent.first; at < extent.end; at += lanes, pixels += 4 * lanes) {
      const auto column = hn::Iota(d32, static_cast<std::int32_t>(at));
      const auto dx = hn::ConvertTo(d, column);
      const auto u = fused(p00, dx, u0), v = fused(p10, dx, v0);
      const auto k = hn::Neg(fused(u, u, hn::Mul(v, v)));
      const auto q = hn::Add(fused(a, dx, k), linear);
      const auto inside = hn::RebindMask(d, hn::Lt(column, end));
      const auto w = hn::IfThenElseZero(inside, hn::Max(q, hn::Zero(d)));
      largest = hn::Max(largest, w);
      const auto weights = hn::Mul(w, w);
      add_to(pixels, spread_.get<0>(weights), colour);
      add_to(pixels + lanes, spread_.get<1>(weights), colour);
      add_to(pixels + 2 * lanes, spread_.get<2>(weights), colour);
      add_to(pixels + 3 * lanes, spread_.get<3>(weights), colour);
    }
    return !hn::AllFalse(d, hn::Gt(largest, hn::Zero(d)));
  }

  const SliceBuffer& slice_;
  PixelRun* written_;
  const Footprint& footprint_;
  KernelReach reach_;
  Spread spread_;
};

DrawCounts DrawByRows(const SliceBuffer& slice, const Footprint& footprint, const SplatRun& run,
                      PixelRun* written) {
  return draw_each(run, RowPainter(slice, footprint, written));
}

class TexturePainter {
 public:
  HWY_INLINE TexturePainter(const SliceBuffer& slice, const FootprintTable& table, PixelRun* written)
      : slice_(slice), table_(table), written_(written) {}

  HWY_INLINE bool operator()(const Splat& splat, std::int64_t x, std::int64_t y) const {
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
      add(slice_.origin + row * slice_.row_floats + (x + first) * 4,
          table_.weights.data() + at * table_.row + (first + table_.reach_x), colour,
          static_cast<int>(end - first));
    }
    return reached;
  }

 private:
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

  const SliceBuffer& slice_;
  const FootprintTable& table_;
  PixelRun* written_;
  Spread spread_;
};

DrawCounts DrawWithTexture(const SliceBuffer& slice, const FootprintTable& table, const SplatRun& run,
                           PixelRun* written) {
  return draw_each(run, TexturePainter(slice, table, written));
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(DrawWithStencil);
HWY_EXPORT(DrawByRows);
HWY_EXPORT(DrawWithTexture);

DrawCounts draw_with_stencil(const SliceBuffer& slice, const Stencil& stencil, const SplatRun& run,
                             PixelRun* anchors) {
  return HWY_DYNAMIC_DISPATCH(DrawWithStencil)(slice, stencil, run, anchors);
}

DrawCounts draw_by_rows(const SliceBuffer& slice, const Footprint& footprint, const SplatRun& run,
                        PixelRun* written) {
  return HWY_DYNAMIC_DISPATCH(DrawByRows)(slice, footprint, run, written);
}

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
  const auto floats = [&] { return std::size_t(phases) * std::size_t(phases) * table.rows() * table.row; };
  while (phases > 1 && floats() > most_floats) --phases;
  table.phases = phases;

  const double determinant = 4 * footprint.d * footprint.f - footprint.e * footprint.e;
  table.x_of_a = -2 * footprint.f / determinant;
  table.x_of_b = table.y_of_a = footprint.e / determinant;
  table.y_of_b = -2 * footprint.d / determinant;

  table.weights.assign(floats(), 0.0F);
  table.covered.resize(floats() / table.row);
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
