#include "splat/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/warp_image.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "ringsplat/splat/warp_image.hpp"
#include "splat/pixel_vectors-inl.hpp"
#include "splat/warp_row.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if RINGSPLAT_ONE_BY_ONE

struct Weights {
  float at[4];
};
Weights cubic_weights(float f) {
  Weights w;
  for (int k = 0; k < 4; ++k)
    w.at[k] = std::fma(std::fma(std::fma(cubic[3][k], f, cubic[2][k]), f, cubic[1][k]), f, cubic[0][k]);
  return w;
}

struct Spread {};

void InterpolatePixel(const float* taps, std::ptrdiff_t row_floats, float fx, float fy, const Spread&,
                      float* out) {
  const Weights wx = cubic_weights(fx), wy = cubic_weights(fy);
  float product[4][4];
  for (int column = 0; column < 4; ++column) {
    for (int k = 0; k < 4; ++k) {
      const float* tap = taps + 4 * column + k;
      float sum = wy.at[0] * tap[0];
      for (int row = 1; row < 4; ++row) sum = std::fma(wy.at[row], tap[row * row_floats], sum);
      product[column][k] = wx.at[column] * sum;
    }
  }
  float rgba[4];
  for (int k = 0; k < 4; ++k) rgba[k] = (product[0][k] + product[1][k]) + (product[2][k] + product[3][k]);
  const float opacity = std::min(std::max(rgba[3], 0.0F), 1.0F);
  for (int k = 0; k < 4; ++k) out[k] = std::min(std::max(rgba[k], 0.0F), opacity);
}

#else

HWY_INLINE hn::Vec<FourFloats> cubic_weights(float fraction) {
  const FourFloats d;
  const auto f = hn::Set(d, fraction);
  auto w = hn::MulAdd(hn::Load(d, cubic[3]), f, hn::Load(d, cubic[2]));
  w = hn::MulAdd(w, f, hn::Load(d, cubic[1]));
  return hn::MulAdd(w, f, hn::Load(d, cubic[0]));
}

/// Sums four rows of taps, as many columns at once as a vector has pixels, and weights each column.
class Columns {
 public:
  HWY_INLINE Columns(hn::Vec<FourFloats> wx, hn::Vec<FourFloats> wy) {
    HWY_ALIGN float x[16], y[4];
    hn::Store(wx, FourFloats(), x);
    hn::Store(wy, FourFloats(), y);
    wx_ = hn::LoadDup128(Floats(), x);
    for (int row = 0; row < 4; ++row) wy_[row] = hn::Set(Floats(), y[row]);
  }
  /// The `part`-th vector of columns from `taps` on.
  template <int part>
  HWY_INLINE FloatVector get(const float* taps, std::ptrdiff_t row_floats, const Spread& spread) const {
    const Floats d;
    const float* tap = taps + std::size_t{part} * lanes;
    auto sum = hn::Mul(wy_[0], hn::LoadU(d, tap));
    for (int row = 1; row < 4; ++row) sum = hn::MulAdd(wy_[row], hn::LoadU(d, tap + row * row_floats), sum);
    return hn::Mul(spread.get<part>(wx_), sum);
  }

 private:
  FloatVector wx_, wy_[4];
};

/// (c0 + c1) + (c2 + c3) of the columns c.
HWY_INLINE hn::Vec<FourFloats> sum_columns(const Columns& columns, const float* taps,
                                           std::ptrdiff_t row_floats, const Spread& spread) {
#if HWY_MAX_BYTES >= 64
  const hn::Half<Floats> two;
  const hn::Half<hn::Half<Floats>> one;
  const auto all = columns.get<0>(taps, row_floats, spread);
  const auto left = hn::LowerHalf(two, all), right = hn::UpperHalf(two, all);
  return hn::Add(hn::Add(hn::LowerHalf(one, left), hn::UpperHalf(one, left)),
                 hn::Add(hn::LowerHalf(one, right), hn::UpperHalf(one, right)));
#elif HWY_MAX_BYTES == 32
  const hn::Half<Floats> one;
  const auto left = columns.get<0>(taps, row_floats, spread),
             right = columns.get<1>(taps, row_floats, spread);
  return hn::Add(hn::Add(hn::LowerHalf(one, left), hn::UpperHalf(one, left)),
                 hn::Add(hn::LowerHalf(one, right), hn::UpperHalf(one, right)));
#else
  return hn::Add(hn::Add(columns.get<0>(taps, row_floats, spread), columns.get<1>(taps, row_floats, spread)),
                 hn::Add(columns.get<2>(taps, row_floats, spread), columns.get<3>(taps, row_floats, spread)));
#endif
}

/// `taps`: the first of four pixels in the first of four rows.
HWY_INLINE void InterpolatePixel(const float* taps, std::ptrdiff_t row_floats, float fx, float fy,
                                 const Spread& spread, float* out) {
  const FourFloats d;
  const auto rgba = sum_columns(Columns(cubic_weights(fx), cubic_weights(fy)), taps, row_floats, spread);
  const auto zero = hn::Zero(d);
  const auto opacity = hn::Min(hn::Max(hn::Broadcast<3>(rgba), zero), hn::Set(d, 1.0F));
  hn::StoreU(hn::Min(hn::Max(rgba, zero), opacity), d, out);
}

#endif

void WarpRow(const WarpedRow& row, float* screen) {
  const Spread spread;
  for (int x = row.first; x < row.end; ++x) {
    const double px = std::fma(row.step_x, double(x), row.start_x),
                 py = std::fma(row.step_y, double(x), row.start_y);
    // The places lie above 0, where truncation is floor.
    const auto ix = static_cast<std::int32_t>(px), iy = static_cast<std::int32_t>(py);
    const float* taps = row.plane + iy * row.row_floats + ix * std::ptrdiff_t{4};
    InterpolatePixel(taps, row.row_floats, static_cast<float>(px - ix), static_cast<float>(py - iy), spread,
                     screen + std::ptrdiff_t{4} * x);
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {
namespace {

HWY_EXPORT(WarpRow);

/// Narrows columns [first, end) to those with low ≤ start + step · x ≤ high.
void narrow(double start, double step, double low, double high, double& first, double& end) {
  if (step == 0) {
    if (!(start >= low && start <= high)) end = first;
    return;
  }
  const double a = (low - start) / step, b = (high - start) / step;
  first = std::max(first, std::ceil(std::min(a, b)));
  end = std::min(end, std::floor(std::max(a, b)) + 1);
}

bool lies_within(const WarpedRow& row, int x, const PixelWindow& firsts) {
  const double px = std::fma(row.step_x, double(x), row.start_x),
               py = std::fma(row.step_y, double(x), row.start_y);
  return px >= double(firsts.x0) && px < double(firsts.x1 + 1) && py >= double(firsts.y0) &&
         py < double(firsts.y1 + 1);
}

bool is_clear(const float* pixel) {
  return std::all_of(pixel, pixel + 4, [](float value) { return value == 0; });
}

/// The smallest window with all pixels of `window` that are not 0; empty when none is.
PixelWindow not_clear(const Image& plane, const PixelWindow& window) {
  PixelWindow found{plane.width, plane.height, -1, -1};
  for (std::int64_t y = window.y0; y <= window.y1; ++y) {
    const float* row = plane.pixel(0, int(y));
    std::int64_t first = window.x0, last = window.x1;
    while (first <= last && is_clear(row + 4 * first)) ++first;
    if (first > last) continue;
    while (is_clear(row + 4 * last)) --last;
    found = {std::min(found.x0, first), std::min(found.y0, y), std::max(found.x1, last), y};
  }
  return found;
}

}  // namespace

void warp_image(const Image& plane, const PixelWindow& window, const PlaneWarp& warp, Image& screen) {
  const PixelWindow filled = not_clear(plane, window);
  // The first of a place's four taps along each axis: those that see a filled pixel and whose four lie in the
  // image.
  const PixelWindow firsts{std::max<std::int64_t>(filled.x0 - 3, 0), std::max<std::int64_t>(filled.y0 - 3, 0),
                           std::min<std::int64_t>(filled.x1, plane.width - 4),
                           std::min<std::int64_t>(filled.y1, plane.height - 4)};
  if (firsts.x0 > firsts.x1 || firsts.y0 > firsts.y1) return;
  for (int y = 0; y < screen.height; ++y) {
    // The first tap's centre lies between one and two pixels before the place.
    const glm::dvec2 start = warp.from_screen({0.5, y + 0.5}) - 1.5;
    WarpedRow row{plane.rgba.data(),
                  std::ptrdiff_t{4} * plane.width,
                  start.x,
                  start.y,
                  warp.linear[0].x,
                  warp.linear[0].y,
                  0,
                  0};
    double first = 0, end = screen.width;
    narrow(row.start_x, row.step_x, double(firsts.x0), double(firsts.x1 + 1), first, end);
    narrow(row.start_y, row.step_y, double(firsts.y0), double(firsts.y1 + 1), first, end);
    if (!(first < end)) continue;
    row.first = static_cast<int>(first);
    row.end = static_cast<int>(end);
    // Rounding may have let in a column too many at either end.
    while (row.first < row.end && !lies_within(row, row.first, firsts)) ++row.first;
    while (row.first < row.end && !lies_within(row, row.end - 1, firsts)) --row.end;
    HWY_DYNAMIC_DISPATCH(WarpRow)(row, screen.pixel(0, y));
  }
}

}  // namespace ringsplat
#endif
