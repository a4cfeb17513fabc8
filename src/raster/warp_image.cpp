#include "raster/warp_image.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/warp_image.cpp"
#include <hwy/foreach_target.h>

#include <cmath>

#include "raster/pixel_vectors-inl.hpp"

#ifndef RINGSPLAT_WARP_IMAGE_ONCE
#define RINGSPLAT_WARP_IMAGE_ONCE
namespace ringsplat {
namespace {

/// Catmull and Rom's weights of the four taps as polynomials of the fraction: [power][tap] coefficients.
alignas(16) constexpr float cubic[4][4] = {
    {0, 1, 0, 0}, {-0.5F, 0, 0.5F, 0}, {1, -2.5F, 2, -0.5F}, {-0.5F, 1.5F, -1.5F, 0.5F}};

/// One row of the picture. The first tap of its pixel x lies at start + x · step in the plane, rounded down.
struct WarpedRow {
  const float* plane;         ///< RGBA
  std::ptrdiff_t row_floats;  ///< of the plane
  glm::dvec2 start, step;
  int first = 0, end = 0;  ///< pixels to fill are first … end − 1; all their taps lie in the plane
};

}  // namespace
}  // namespace ringsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// Pixels whose places are found at a time.
inline constexpr int most_places = 64;

/// Finds first taps and the four taps' weights, [tap][pixel], along one axis, of places start + k · step from
/// k = first on. Places are positive, so that truncation is floor. Compilers make vectors of pixels of the
/// plain loops.
HWY_INLINE void find_taps(double start, double step, int first, int count, std::int32_t* HWY_RESTRICT taps,
                          float (*weights)[most_places]) {
  float fraction[most_places];
  for (int k = 0; k < count; ++k) {
    const double place = std::fma(step, double(first + k), start);
    taps[k] = static_cast<std::int32_t>(place);
    fraction[k] = static_cast<float>(place - taps[k]);
  }
  for (int tap = 0; tap < 4; ++tap) {
    float* HWY_RESTRICT w = weights[tap];
    for (int k = 0; k < count; ++k)
      w[k] =
          std::fma(std::fma(std::fma(cubic[3][tap], fraction[k], cubic[2][tap]), fraction[k], cubic[1][tap]),
                   fraction[k], cubic[0][tap]);
  }
}

/// Clamps what the cubic's negative lobes bring out of range.
HWY_INLINE hn::Vec<FourFloats> clamp_pixel(hn::Vec<FourFloats> rgba) {
  const FourFloats d;
  const auto zero = hn::Zero(d);
  const auto opacity = hn::Min(hn::Max(hn::Broadcast<3>(rgba), zero), hn::Set(d, 1.0F));
  return hn::Min(hn::Max(rgba, zero), opacity);
}

/// Some of a row's pixels: their first taps, and [tap][pixel] weights along both axes.
struct Places {
  std::ptrdiff_t tap[most_places];  ///< in floats from the plane's first
  float wx[4][most_places], wy[4][most_places];
};

/// Returns (c0 + c1) + (c2 + c3) of the columns c, each the weighted sum of four taps. `taps`: the first of
/// four pixels in the first of four rows. `k`: which of the places' weights they have.
HWY_INLINE hn::Vec<FourFloats> sum_columns(const float* taps, std::ptrdiff_t row_floats, const Places& places,
                                           int k) {
  const FourFloats d;
  const auto column = [&](int c) {
    const float* tap = taps + std::ptrdiff_t{4} * c;
    auto sum = hn::Mul(hn::Set(d, places.wy[0][k]), hn::LoadU(d, tap));
    for (int row = 1; row < 4; ++row)
      sum = fused(hn::Set(d, places.wy[row][k]), hn::LoadU(d, tap + row * row_floats), sum);
    return hn::Mul(hn::Set(d, places.wx[c][k]), sum);
  };
  return hn::Add(hn::Add(column(0), column(1)), hn::Add(column(2), column(3)));
}

/// Fills the row's pixels first … end − 1, each from sixteen pixels of the plane. `screen`: the row's first
/// pixel.
void WarpRow(const WarpedRow& row, float* screen) {
  Places places;
  std::int32_t columns[most_places], rows[most_places];
  for (int first = row.first; first < row.end; first += most_places) {
    const int count = std::min(row.end - first, most_places);
    find_taps(row.start.x, row.step.x, first, count, columns, places.wx);
    find_taps(row.start.y, row.step.y, first, count, rows, places.wy);
    for (int k = 0; k < count; ++k) places.tap[k] = rows[k] * row.row_floats + columns[k] * std::ptrdiff_t{4};
    for (int k = 0; k < count; ++k)
      hn::StoreU(clamp_pixel(sum_columns(row.plane + places.tap[k], row.row_floats, places, k)), FourFloats(),
                 screen + std::ptrdiff_t{4} * (first + k));
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(WarpRow);

namespace {

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
  const double px = std::fma(row.step.x, double(x), row.start.x),
               py = std::fma(row.step.y, double(x), row.start.y);
  return px >= double(firsts.x0) && px < double(firsts.x1 + 1) && py >= double(firsts.y0) &&
         py < double(firsts.y1 + 1);
}

bool is_clear(const float* pixel) {
  return std::all_of(pixel, pixel + 4, [](float value) { return value == 0; });
}

/// The smallest part of `window` with all of its pixels that are not 0; empty when all are.
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
  WarpedRow row{.plane = plane.rgba.data(),
                .row_floats = std::ptrdiff_t{4} * plane.width,
                // The first tap's centre lies between one and two pixels before the position.
                .start = warp.from_screen({0.5, y + 0.5}) - 1.5,
                .step = warp.linear[0]};
  if (firsts.x0 > firsts.x1 || firsts.y0 > firsts.y1) return row;
  double first = 0, end = width;
  narrow(row.start.x, row.step.x, double(firsts.x0), double(firsts.x1 + 1), first, end);
  narrow(row.start.y, row.step.y, double(firsts.y0), double(firsts.y1 + 1), first, end);
  if (!(first < end)) return row;
  row.first = static_cast<int>(first);
  row.end = static_cast<int>(end);
  // Rounding may have left a column too many at either end.
  while (row.first < row.end && !lies_within(row, row.first, firsts)) ++row.first;
  while (row.first < row.end && !lies_within(row, row.end - 1, firsts)) --row.end;
  return row;
}

}  // namespace

Image warp_image(const Image& plane, const PixelWindow& window, const PlaneWarp& warp, int width,
                 int height) {
  const PixelWindow filled = not_clear(plane, window);
  // The first of a position's four taps along each axis: one of the four must see a filled pixel, and all
  // must lie in the image.
  const PixelWindow firsts{std::max<std::int64_t>(filled.x0 - 3, 0), std::max<std::int64_t>(filled.y0 - 3, 0),
                           std::min<std::int64_t>(filled.x1, plane.width - 4),
                           std::min<std::int64_t>(filled.y1, plane.height - 4)};
  Image screen = Image::uninitialised(width, height);
  for (int y = 0; y < height; ++y) {
    const WarpedRow row = seen_of_row(plane, firsts, warp, y, width);
    std::fill(screen.pixel(0, y), screen.pixel(row.first, y), 0.0F);
    std::fill(screen.pixel(row.end, y), screen.pixel(0, y + 1), 0.0F);
    HWY_DYNAMIC_DISPATCH(WarpRow)(row, screen.pixel(0, y));
  }
  return screen;
}

}  // namespace ringsplat
#endif
