#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/draw_splats.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>

#include "raster/pixel_vectors-inl.hpp"
#include "splat/splat.hpp"
#include "splat/splat_sum.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// Whether a, b, c and the opacity are all numbers that a footprint can give.
HWY_INLINE bool is_plausible(const Splat& splat) {
  const FourFloats d;
  const auto words = hn::LoadU(d, &splat.a);
  return hn::AllTrue(d, hn::Lt(hn::Abs(words), hn::Set(d, largest_coefficient)));
}

/// A splat's premultiplied colour, once for each pixel of a vector.
HWY_INLINE Colour load_colour(const Splat& splat) {
  const FourFloats d;
  const hn::Rebind<std::int32_t, FourFloats> d32;
  const hn::Rebind<std::uint16_t, FourFloats> d16;
  const auto straight = hn::ConvertTo(d, hn::PromoteTo(d32, hn::LoadU(d16, &splat.red)));
  const auto premultiplied = hn::Mul(straight, hn::Set(d, splat.opacity * (1.0F / 65535.0F)));
  HWY_ALIGN float colour[4];
  hn::Store(hn::IfThenElse(hn::FirstN(d, 3), premultiplied, hn::Set(d, splat.opacity)), d, colour);
  return hn::LoadDup128(Floats(), colour);
}

/// Draws all plausible splats: draw_one(splat, x, y) gets the anchor, from the region's corner, and returns
/// whether the kernel reaches a pixel centre of the region.
template <class DrawOne>
HWY_INLINE DrawCounts draw_each(std::span<const Splat> splats, int left, int top, DrawOne draw_one) {
  DrawCounts counts;
  for (const Splat& splat : splats)
    if (is_plausible(splat) && draw_one(splat, splat.anchor_x - left, splat.anchor_y - top)) ++counts.drawn;
  counts.clipped = splats.size() - counts.drawn;
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
    anchors_[y + top + 1].include(int(x), int(x) + 1);
    return add(splat, int(x), int(y));
  }

 private:
  HWY_INLINE bool add(const Splat& splat, int x, int y) const {
    const Floats d;
    const auto a = hn::Set(d, splat.a), b = hn::Set(d, splat.b), c = hn::Set(d, splat.c);
    const auto left = hn::Set(d, float(-x)), top = hn::Set(d, float(-y)),
               right = hn::Set(d, float(slice_.width - 1 - x)),
               bottom = hn::Set(d, float(slice_.height - 1 - y));
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

/// Half-open run of pixels, as offsets from the anchor.
struct OffsetRun {
  std::int64_t first, end;
  bool empty() const { return first >= end; }
  OffsetRun within(const OffsetRun& other) const {
    return {std::max(first, other.first), std::min(end, other.end)};
  }
};

/// Draws splats row by row, clipped to the region.
class RowPainter {
 public:
  HWY_INLINE RowPainter(const SliceBuffer& slice, const Footprint& footprint, PixelRun* written)
      : slice_(slice), footprint_(footprint), reach_(kernel_reach(footprint)), written_(written) {}

  /// Returns whether the splat reaches a pixel.
  HWY_INLINE bool operator()(const Splat& splat, std::int64_t x, std::int64_t y) const {
    const OffsetRun columns{std::max(-x, -reach_.x), std::min(slice_.width - x, reach_.x + 2)},
        rows{std::max(-y, -reach_.y), std::min(slice_.height - y, reach_.y + 2)};
    if (columns.empty()) return false;
    const Colour colour = load_colour(splat);
    bool reached = false;
    for (std::int64_t dy = rows.first; dy < rows.end; ++dy) {
      const OffsetRun extent = positive(splat, double(dy)).within(columns);
      if (extent.empty()) continue;
      const auto row = std::ptrdiff_t(y + dy);
      const auto first = std::int32_t(x + extent.first);
      written_[row].include(first, std::int32_t(x + extent.end));
      reached |= add(splat, double(dy), extent, colour,
                     slice_.origin + row * slice_.row_floats + first * std::ptrdiff_t{4});
    }
    return reached;
  }

 private:
  /// The pixels where the quadratic of the splat's row is positive. There is no NaN: coefficients are finite
  /// and D < 0.
  OffsetRun positive(const Splat& splat, double dy) const {
    const double b = double(splat.a) + footprint_.e * dy;
    const double c = double(splat.c) + double(splat.b) * dy + footprint_.f * dy * dy;
    const double discriminant = b * b - 4 * footprint_.d * c;
    if (!(discriminant > 0)) return {0, 0};
    const double root = std::sqrt(discriminant), scale = -2 * footprint_.d;
    const auto before = -double(reach_.x) - 1, after = double(reach_.x) + 2;
    return {std::int64_t(std::ceil(std::clamp((b - root) / scale, before, after))),
            std::int64_t(std::floor(std::clamp((b + root) / scale, before, after))) + 1};
  }

  /// Adds to a row of the splat's. Returns whether any of the weights is positive. `pixels`: the extent's
  /// first.
  HWY_INLINE bool add(const Splat& splat, double dy, const OffsetRun& extent, const Colour& colour,
                      float* pixels) const {
    const Floats d;
    const hn::Rebind<std::int32_t, Floats> d32;
    const auto set = [&](double value) { return hn::Set(d, float(value)); };
    const auto& p = footprint_.p;
    const auto a = hn::Set(d, splat.a), linear = hn::Set(d, std::fma(splat.b, float(dy), splat.c));
    const auto u_dx = set(p[0][0]), v_dx = set(p[0][1]), u0 = set(p[1][0] * dy), v0 = set(p[1][1] * dy);
    auto largest = hn::Zero(d);
    for (std::int64_t at = extent.first; at < extent.end; at += lanes, pixels += 4 * lanes) {
      const auto dx = hn::ConvertTo(d, hn::Iota(d32, std::int32_t(at)));
      const auto u = fused(u_dx, dx, u0), v = fused(v_dx, dx, v0);
      const auto k = hn::Neg(fused(u, u, hn::Mul(v, v)));
      const auto w = hn::Max(hn::Add(fused(a, dx, k), linear), hn::Zero(d));
      const auto inside = hn::FirstN(d, std::min(std::size_t(extent.end - at), lanes));
      const auto weights = hn::IfThenElseZero(inside, hn::Mul(w, w));
      largest = hn::Max(largest, weights);
      add_to(pixels, spread_.get<0>(weights), colour);
      add_to(pixels + lanes, spread_.get<1>(weights), colour);
      add_to(pixels + 2 * lanes, spread_.get<2>(weights), colour);
      add_to(pixels + 3 * lanes, spread_.get<3>(weights), colour);
    }
    return !hn::AllFalse(d, hn::Gt(largest, hn::Zero(d)));
  }

  const SliceBuffer& slice_;
  const Footprint& footprint_;
  KernelReach reach_;
  PixelRun* written_;
  Spread spread_;
};

DrawCounts DrawSplats(const SliceBuffer& slice, const Footprint& footprint, const Stencil* stencil,
                      std::span<const Splat> splats, int left, int top, PixelRun* written) {
  if (stencil != nullptr) return draw_each(splats, left, top, StencilPainter(slice, *stencil, written));
  return draw_each(splats, left, top, RowPainter(slice, footprint, written));
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(DrawSplats);

DrawCounts draw_splats(const SliceBuffer& slice, const Footprint& footprint, const Stencil* stencil,
                       std::span<const Splat> splats, int left, int top, PixelRun* written) {
  return HWY_DYNAMIC_DISPATCH(DrawSplats)(slice, footprint, stencil, splats, left, top, written);
}

}  // namespace ringsplat
#endif
