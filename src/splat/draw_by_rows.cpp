#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/draw_by_rows.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>

#include "splat/painter_kernels.hpp"
#include "splat/splat.hpp"
#include "splat/splat_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// Half-open run of pixels, as offsets from the anchor.
struct OffsetRun {
  std::int64_t first, end;
  bool empty() const { return first >= end; }
};

/// What is the same for all pixels of a splat's row.
struct RowConstants {
  float p00, p10, u0, v0, a, linear;
};

RowConstants row_constants(const Footprint& footprint, const Splat& splat, std::int64_t row) {
  const auto dy = static_cast<double>(row);
  return {static_cast<float>(footprint.p[0][0]),
          static_cast<float>(footprint.p[0][1]),
          static_cast<float>(footprint.p[1][0] * dy),
          static_cast<float>(footprint.p[1][1] * dy),
          splat.a,
          std::fma(splat.b, static_cast<float>(dy), splat.c)};
}

#if RINGSPLAT_ONE_BY_ONE

class RowAdder {
 public:
  bool add(float* pixels, const RowConstants& row, const Colour& colour, const OffsetRun& extent) const {
    bool reached = false;
    for (std::int64_t at = extent.first; at < extent.end; ++at, pixels += 4) {
      const auto dx = static_cast<float>(static_cast<std::int32_t>(at));
      const float u = std::fma(row.p00, dx, row.u0), v = std::fma(row.p10, dx, row.v0);
      const float q = std::fma(row.a, dx, -std::fma(u, u, v * v)) + row.linear;
      if (!(q > 0)) continue;
      reached = true;
      add_to(pixels, q * q, colour);
    }
    return reached;
  }
};

#else

class RowAdder {
 public:
  // An implicit constructor would be compiled without the target's instructions.
  HWY_INLINE RowAdder() {}
  /// Returns whether Q > 0 in any of the pixels. `pixels`: the extent's first.
  HWY_INLINE bool add(float* pixels, const RowConstants& row, const Colour& colour,
                      const OffsetRun& extent) const {
    const Floats d;
    const hn::Rebind<std::int32_t, Floats> d32;
    const auto p00 = hn::Set(d, row.p00), p10 = hn::Set(d, row.p10), u0 = hn::Set(d, row.u0),
               v0 = hn::Set(d, row.v0);
    const auto a = hn::Set(d, row.a), linear = hn::Set(d, row.linear);
    const auto end = hn::Set(d32, static_cast<std::int32_t>(extent.end));
    auto largest = hn::Zero(d);
    for (std::int64_t at = extent.first; at < extent.end; at += lanes, pixels += 4 * lanes) {
      const auto column = hn::Iota(d32, static_cast<std::int32_t>(at));
      const auto dx = hn::ConvertTo(d, column);
      const auto u = hn::MulAdd(p00, dx, u0), v = hn::MulAdd(p10, dx, v0);
      const auto k = hn::Neg(hn::MulAdd(u, u, hn::Mul(v, v)));
      const auto q = hn::Add(hn::MulAdd(a, dx, k), linear);
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

 private:
  Spread spread_;
};

#endif

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
  RowPainter(const SliceBuffer& slice, const Footprint& footprint, PixelRun* written)
      : slice_(slice), written_(written), footprint_(footprint), reach_(kernel_reach(footprint)) {}

  DrawCounts draw(const SplatRun& run) const {
    DrawCounts counts;
    for (std::size_t i = 0; i < run.count; ++i) {
      const Splat splat = load_splat(run.bytes + i * sizeof(Splat));
      if (is_plausible(splat) && draw_one(splat, run.base_x + splat.anchor_x, run.base_y + splat.anchor_y)) {
        ++counts.drawn;
      }
    }
    counts.clipped = run.count - counts.drawn;
    return counts;
  }

 private:
  bool draw_one(const Splat& splat, std::int64_t x, std::int64_t y) const {
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
      reached |= adder_.add(pixels, row_constants(footprint_, splat, dy), colour, extent);
    }
    return reached;
  }

  const SliceBuffer& slice_;
  PixelRun* written_;
  const Footprint& footprint_;
  KernelReach reach_;
  RowAdder adder_;
};

DrawCounts DrawByRows(const SliceBuffer& slice, const Footprint& footprint, const SplatRun& run,
                      PixelRun* written) {
  return RowPainter(slice, footprint, written).draw(run);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(DrawByRows);

DrawCounts draw_by_rows(const SliceBuffer& slice, const Footprint& footprint, const SplatRun& run,
                        PixelRun* written) {
  return HWY_DYNAMIC_DISPATCH(DrawByRows)(slice, footprint, run, written);
}

}  // namespace ringsplat
#endif
