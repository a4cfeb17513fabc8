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

/// Where some of a row's pixels lie: their first tap, and by tap the pixels' weights along both axes. In
/// plain loops, of which a compiler makes vectors of pixels.
struct Places {
  static constexpr int most = 64;
  std::ptrdiff_t tap[most];  ///< floats from the plane's first
  float wx[4][most], wy[4][most];
};

HWY_INLINE void find_weights(const float* HWY_RESTRICT fraction, int count, float (*weights)[Places::most]) {
  for (int tap = 0; tap < 4; ++tap) {
    float* HWY_RESTRICT w = weights[tap];
    for (int k = 0; k < count; ++k)
      w[k] =
          std::fma(std::fma(std::fma(cubic[3][tap], fraction[k], cubic[2][tap]), fraction[k], cubic[1][tap]),
                   fraction[k], cubic[0][tap]);
  }
}

/// Of pixels first … first + count − 1.
HWY_INLINE void find_places(const WarpedRow& row, int first, int count, Places& places) {
  float fx[Places::most], fy[Places::most];
  for (int k = 0; k < count; ++k) {
    const double px = std::fma(row.step_x, double(first + k), row.start_x),
                 py = std::fma(row.step_y, double(first + k), row.start_y);
    // The places lie above 0, where truncation is floor.
    const auto ix = static_cast<std::int32_t>(px), iy = static_cast<std::int32_t>(py);
    places.tap[k] = iy * row.row_floats + ix * std::ptrdiff_t{4};
    fx[k] = static_cast<float>(px - ix);
    fy[k] = static_cast<float>(py - iy);
  }
  find_weights(fx, count, places.wx);
  find_weights(fy, count, places.wy);
}

#if RINGSPLAT_ONE_BY_ONE

void interpolate(const float* taps, std::ptrdiff_t row_floats, const Places& places, int k, float* out) {
  float product[4][4];
  for (int column = 0; column < 4; ++column) {
    for (int channel = 0; channel < 4; ++channel) {
      const float* tap = taps + 4 * column + channel;
      float sum = places.wy[0][k] * tap[0];
      for (int row = 1; row < 4; ++row) sum = std::fma(places.wy[row][k], tap[row * row_floats], sum);
      product[column][channel] = places.wx[column][k] * sum;
    }
  }
  float rgba[4];
  for (int channel = 0; channel < 4; ++channel)
    rgba[channel] = (product[0][channel] + product[1][channel]) + (product[2][channel] + product[3][channel]);
  const float opacity = std::min(std::max(rgba[3], 0.0F), 1.0F);
  for (int channel = 0; channel < 4; ++channel)
    out[channel] = std::min(std::max(rgba[channel], 0.0F), opacity);
}

#else

/// The weights of the columns in the `part`-th vector of a row of taps, each over its pixel's floats.
template <int part>
HWY_INLINE FloatVector column_weights(const Places& places, int k) {
  const auto one = [&](std::size_t column) { return hn::Set(FourFloats(), places.wx[column][k]); };
#if HWY_MAX_BYTES >= 64
  const hn::Half<Floats> two;
  return hn::Combine(Floats(), hn::Combine(two, one(3), one(2)), hn::Combine(two, one(1), one(0)));
#elif HWY_MAX_BYTES == 32
  return hn::Combine(Floats(), one(2 * part + 1), one(2 * part));
#else
  return one(part);
#endif
}

/// The `part`-th vector of columns: sums of four taps, weighted.
template <int part>
HWY_INLINE FloatVector columns(const float* taps, std::ptrdiff_t row_floats, const Places& places, int k) {
  const Floats d;
  const float* tap = taps + std::size_t{part} * lanes;
  auto sum = hn::Mul(hn::Set(d, places.wy[0][k]), hn::LoadU(d, tap));
  for (int row = 1; row < 4; ++row)
    sum = hn::MulAdd(hn::Set(d, places.wy[row][k]), hn::LoadU(d, tap + row * row_floats), sum);
  return hn::Mul(column_weights<part>(places, k), sum);
}

/// (c0 + c1) + (c2 + c3) of the columns c.
HWY_INLINE hn::Vec<FourFloats> sum_columns(const float* taps, std::ptrdiff_t row_floats, const Places& places,
                                           int k) {
#if HWY_MAX_BYTES >= 64
  const hn::Half<Floats> two;
  const hn::Half<hn::Half<Floats>> one;
  const auto all = columns<0>(taps, row_floats, places, k);
  const auto left = hn::LowerHalf(two, all), right = hn::UpperHalf(two, all);
  return hn::Add(hn::Add(hn::LowerHalf(one, left), hn::UpperHalf(one, left)),
                 hn::Add(hn::LowerHalf(one, right), hn::UpperHalf(one, right)));
#elif HWY_MAX_BYTES == 32
  const hn::Half<Floats> one;
  const auto left = columns<0>(taps, row_floats, places, k), right = columns<1>(taps, row_floats, places, k);
  return hn::Add(hn::Add(hn::LowerHalf(one, left), hn::UpperHalf(one, left)),
                 hn::Add(hn::LowerHalf(one, right), hn::UpperHalf(one, right)));
#else
  return hn::Add(hn::Add(columns<0>(taps, row_floats, places, k), columns<1>(taps, row_floats, places, k)),
                 hn::Add(columns<2>(taps, row_floats, places, k), columns<3>(taps, row_floats, places, k)));
#endif
}

/// `taps`: the first of four pixels in the first of four rows; their weights are the k-th.
HWY_INLINE void interpolate(const float* taps, std::ptrdiff_t row_floats, const Places& places, int k,
                            float* out) {
  const FourFloats d;
  const auto rgba = sum_columns(taps, row_floats, places, k);
  const auto zero = hn::Zero(d);
  const auto opacity = hn::Min(hn::Max(hn::Broadcast<3>(rgba), zero), hn::Set(d, 1.0F));
  hn::StoreU(hn::Min(hn::Max(rgba, zero), opacity), d, out);
}

#endif

void WarpRow(const WarpedRow& row, float* screen) {
  Places places;
  for (int first = row.first; first < row.end; first += Places::most) {
    const int count = std::min(row.end - first, Places::most);
    find_places(row, first, count, places);
    for (int k = 0; k < count; ++k)
      interpolate(row.plane + places.tap[k], row.row_floats, places, k,
                  screen + std::ptrdiff_t{4} * (first + k));
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

/// The screen's row y, narrowed to the pixels whose first taps lie in `firsts`.
WarpedRow seen_of_row(const Image& plane, const PixelWindow& firsts, const PlaneWarp& warp, int y,
                      int width) {
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
  if (firsts.x0 > firsts.x1 || firsts.y0 > firsts.y1) return row;
  double first = 0, end = width;
  narrow(row.start_x, row.step_x, double(firsts.x0), double(firsts.x1 + 1), first, end);
  narrow(row.start_y, row.step_y, double(firsts.y0), double(firsts.y1 + 1), first, end);
  if (!(first < end)) return row;
  row.first = static_cast<int>(first);
  row.end = static_cast<int>(end);
  // Rounding may have let in a column too many at either end.
  while (row.first < row.end && !lies_within(row, row.first, firsts)) ++row.first;
  while (row.first < row.end && !lies_within(row, row.end - 1, firsts)) --row.end;
  return row;
}

}  // namespace

Image warp_image(const Image& plane, const PixelWindow& window, const PlaneWarp& warp, int width,
                 int height) {
  const PixelWindow filled = not_clear(plane, window);
  // The first of a place's four taps along each axis: those that see a filled pixel and whose four lie in the
  // image.
  const PixelWindow firsts{std::max<std::int64_t>(filled.x0 - 3, 0), std::max<std::int64_t>(filled.y0 - 3, 0),
                           std::min<std::int64_t>(filled.x1, plane.width - 4),
                           std::min<std::int64_t>(filled.y1, plane.height - 4)};
  Image screen = Image::uninitialised(width, height);
  for (int y = 0; y < height; ++y) {
    const WarpedRow row = seen_of_row(plane, firsts, warp, y, width);
    std::fill(screen.pixel(0, y), screen.pixel(row.first, y), 0.0F);
    HWY_DYNAMIC_DISPATCH(WarpRow)(row, screen.pixel(0, y));
    std::fill(screen.pixel(row.end, y), screen.pixel(0, y + 1), 0.0F);
  }
  return screen;
}

}  // namespace ringsplat
#endif
