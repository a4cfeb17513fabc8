#include "raster/warp_columns.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/warp_columns.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "raster/warp_weights-inl.hpp"

#ifndef RINGSPLAT_WARP_COLUMNS_ONCE
#define RINGSPLAT_WARP_COLUMNS_ONCE
namespace ringsplat {
namespace {

/// The plane's rows, interpolated at the places of some of the picture's columns. A column's pixels lie
/// together, as the second pass needs them.
struct ColumnStrip {
  int first, end;         ///< columns of the picture
  int first_row, rows;    ///< of the plane
  float* pixels;          ///< RGBA
  std::ptrdiff_t stride;  ///< floats from a column to the next
  float* at(int column) const { return pixels + (column - first) * stride; }
};

}  // namespace
}  // namespace ringsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

#if RINGSPLAT_ONE_BY_ONE

/// The weights of four neighbouring pixels.
struct FourWeights {
  float of[4];
  static FourWeights get(const float (*weights)[most_places], int k) {
    return {{weights[0][k], weights[1][k], weights[2][k], weights[3][k]}};
  }
};

/// Two of the resulting pixels.
struct Pair {
  float rgba[2][4];
};

/// Returns (w0 p0 + w2 p2) + (w1 p1 + w3 p3) of the pixels from p on, and likewise from q on.
Pair weigh(const float* p, const FourWeights& w, const float* q, const FourWeights& v) {
  const auto sum = [](const float* pixels, const float* of, int channel) {
    const float* c = pixels + channel;
    return std::fma(of[2], c[8], of[0] * c[0]) + std::fma(of[3], c[12], of[1] * c[4]);
  };
  Pair pair;
  for (int channel = 0; channel < 4; ++channel) {
    pair.rgba[0][channel] = sum(p, w.of, channel);
    pair.rgba[1][channel] = sum(q, v.of, channel);
  }
  return pair;
}

Pair clamp(Pair pair) {
  for (auto& rgba : pair.rgba) store_clamped(rgba, rgba);
  return pair;
}

void store_first(const Pair& pair, float* out) { std::copy_n(pair.rgba[0], 4, out); }
void store(const Pair& pair, float* out) {
  store_first(pair, out);
  std::copy_n(pair.rgba[1], 4, out + 4);
}

#elif HWY_MAX_BYTES >= 32

using TwoPixels = hn::CappedTag<float, 8>;
using Pair = hn::Vec<TwoPixels>;

struct FourWeights {
  Pair near, far;  ///< of two pixels, each over its pixel's floats
  static HWY_INLINE FourWeights get(const float (*weights)[most_places], int k) {
    const auto one = [&](int tap) { return hn::Set(FourFloats(), weights[tap][k]); };
    return {hn::Combine(TwoPixels(), one(1), one(0)), hn::Combine(TwoPixels(), one(3), one(2))};
  }
};

HWY_INLINE Pair weigh(const float* p, const FourWeights& w, const float* q, const FourWeights& v) {
  const TwoPixels d;
  const auto sums = [&](const float* pixels, const FourWeights& of) {
    return hn::MulAdd(of.far, hn::LoadU(d, pixels + 8), hn::Mul(of.near, hn::LoadU(d, pixels)));
  };
  const auto first = sums(p, w), second = sums(q, v);
  return hn::Add(hn::ConcatLowerLower(d, second, first), hn::ConcatUpperUpper(d, second, first));
}

HWY_INLINE Pair clamp(Pair pair) { return clamp_pixels(TwoPixels(), pair); }
HWY_INLINE void store(Pair pair, float* out) { hn::StoreU(pair, TwoPixels(), out); }
HWY_INLINE void store_first(Pair pair, float* out) {
  const hn::Half<TwoPixels> one;
  hn::StoreU(hn::LowerHalf(one, pair), one, out);
}

#else

struct Pair {
  hn::Vec<FourFloats> first, second;
};

struct FourWeights {
  hn::Vec<FourFloats> w0, w1, w2, w3;
  static HWY_INLINE FourWeights get(const float (*weights)[most_places], int k) {
    const auto one = [&](int tap) { return hn::Set(FourFloats(), weights[tap][k]); };
    return {one(0), one(1), one(2), one(3)};
  }
};

HWY_INLINE Pair weigh(const float* p, const FourWeights& w, const float* q, const FourWeights& v) {
  const FourFloats d;
  const auto sum = [&](const float* pixels, const FourWeights& of) {
    return hn::Add(hn::MulAdd(of.w2, hn::LoadU(d, pixels + 8), hn::Mul(of.w0, hn::LoadU(d, pixels))),
                   hn::MulAdd(of.w3, hn::LoadU(d, pixels + 12), hn::Mul(of.w1, hn::LoadU(d, pixels + 4))));
  };
  return {sum(p, w), sum(q, v)};
}

HWY_INLINE Pair clamp(const Pair& pair) {
  return {clamp_pixels(FourFloats(), pair.first), clamp_pixels(FourFloats(), pair.second)};
}
HWY_INLINE void store_first(const Pair& pair, float* out) { hn::StoreU(pair.first, FourFloats(), out); }
HWY_INLINE void store(const Pair& pair, float* out) {
  store_first(pair, out);
  hn::StoreU(pair.second, FourFloats(), out + 4);
}

#endif

/// First pass: interpolates the plane's rows at the columns' places.
void AlongRows(const WarpedRow& any_row, const ColumnStrip& columns) {
  const int count = columns.end - columns.first;
  std::int32_t taps[most_places];
  float weights[4][most_places];
  find_taps(any_row.start_x, any_row.step_x, columns.first, count, taps, weights);
  FourWeights of_column[most_places];
  for (int k = 0; k < count; ++k) of_column[k] = FourWeights::get(weights, k);
  const std::ptrdiff_t row_floats = any_row.row_floats;
  const float* row = any_row.plane + columns.first_row * row_floats;
  for (int y = 0; y < columns.rows; y += 2, row += 2 * row_floats) {
    const bool two = y + 1 < columns.rows;
    for (int k = 0; k < count; ++k) {
      const float* pixels = row + std::ptrdiff_t{4} * taps[k];
      const Pair pair = weigh(pixels, of_column[k], two ? pixels + row_floats : pixels, of_column[k]);
      // A column has room for an even number of pixels.
      store(pair, columns.pixels + k * columns.stride + std::ptrdiff_t{4} * y);
    }
  }
}

/// Second pass: fills the columns' pixels in one of the picture's rows.
void DownColumns(const WarpedRow& row, const ColumnStrip& columns, float* screen) {
  const int first = std::max(row.first, columns.first), count = std::min(row.end, columns.end) - first;
  if (count <= 0) return;
  std::int32_t taps[most_places];
  float weights[4][most_places];
  find_taps(row.start_y, row.step_y, first, count, taps, weights);
  const float* column = columns.at(first) - std::ptrdiff_t{4} * columns.first_row;
  const auto two_from = [&](int k, int next) {
    return clamp(weigh(
        column + k * columns.stride + std::ptrdiff_t{4} * taps[k], FourWeights::get(weights, k),
        column + next * columns.stride + std::ptrdiff_t{4} * taps[next], FourWeights::get(weights, next)));
  };
  float* out = screen + std::ptrdiff_t{4} * first;
  for (int k = 0; k + 1 < count; k += 2) store(two_from(k, k + 1), out + std::ptrdiff_t{4} * k);
  if (count % 2 != 0) store_first(two_from(count - 1, count - 1), out + std::ptrdiff_t{4} * (count - 1));
}

void WarpColumns(std::span<const WarpedRow> rows, const ColumnStrip& columns, Image& screen) {
  AlongRows(rows.front(), columns);
  for (std::size_t y = 0; y < rows.size(); ++y) DownColumns(rows[y], columns, screen.pixel(0, int(y)));
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(WarpColumns);

void warp_columns(std::span<const WarpedRow> rows, int first_tap, int last_tap, Image& screen) {
  int first = screen.width, end = 0;
  for (const WarpedRow& row : rows) {
    if (row.first >= row.end) continue;
    first = std::min(first, row.first);
    end = std::max(end, row.end);
  }
  if (first >= end) return;
  // As many columns as a processor's second-level cache holds. The stride avoids multiples of a page, which
  // would use few of the cache's lines.
  constexpr int most = 32;
  const int plane_rows = last_tap - first_tap + 4;
  const std::ptrdiff_t stride = (std::ptrdiff_t{4} * plane_rows + 31) / 32 * 32 + 16;
  std::vector<float> pixels(std::size_t(most) * std::size_t(stride));
  for (int x = first; x < end; x += most) HWY_DYNAMIC_DISPATCH(WarpColumns)
  (rows, {x, std::min(x + most, end), first_tap, plane_rows, pixels.data(), stride}, screen);
}

}  // namespace ringsplat
#endif
