#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/warp_row.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "raster/warp_row.hpp"
#include "raster/warp_weights-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// Some of a row's pixels: their first taps, and [tap][pixel] weights along both axes.
struct Places {
  std::ptrdiff_t tap[most_places];  ///< in floats from the plane's first
  float wx[4][most_places], wy[4][most_places];
};

/// Finds the places of pixels first … first + count − 1.
HWY_INLINE void find_places(const WarpedRow& row, int first, int count, Places& places) {
  std::int32_t columns[most_places], rows[most_places];
  find_taps(row.start_x, row.step_x, first, count, columns, places.wx);
  find_taps(row.start_y, row.step_y, first, count, rows, places.wy);
  for (int k = 0; k < count; ++k) places.tap[k] = rows[k] * row.row_floats + columns[k] * std::ptrdiff_t{4};
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
  store_clamped(rgba, out);
}

#else

/// The columns' weights in the `part`-th vector of a row of taps, each repeated over its pixel's floats.
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

/// The `part`-th vector of columns: each is the weighted sum of four taps.
template <int part>
HWY_INLINE FloatVector columns(const float* taps, std::ptrdiff_t row_floats, const Places& places, int k) {
  const Floats d;
  const float* tap = taps + std::size_t{part} * lanes;
  auto sum = hn::Mul(hn::Set(d, places.wy[0][k]), hn::LoadU(d, tap));
  for (int row = 1; row < 4; ++row)
    sum = hn::MulAdd(hn::Set(d, places.wy[row][k]), hn::LoadU(d, tap + row * row_floats), sum);
  return hn::Mul(column_weights<part>(places, k), sum);
}

/// Returns (c0 + c1) + (c2 + c3) of the columns c.
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

/// `taps`: the first of four pixels in the first of four rows. `k`: which of the places' weights they have.
HWY_INLINE void interpolate(const float* taps, std::ptrdiff_t row_floats, const Places& places, int k,
                            float* out) {
  const FourFloats d;
  hn::StoreU(clamp_pixels(d, sum_columns(taps, row_floats, places, k)), d, out);
}

#endif

void WarpRow(const WarpedRow& row, float* screen) {
  Places places;
  for (int first = row.first; first < row.end; first += most_places) {
    const int count = std::min(row.end - first, most_places);
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

HWY_EXPORT(WarpRow);

void warp_row(const WarpedRow& row, float* screen) { HWY_DYNAMIC_DISPATCH(WarpRow)(row, screen); }

}  // namespace ringsplat
#endif
