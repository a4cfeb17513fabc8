#include "volume/cell_ranges.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

template <class T>
struct Ends {
  T low, high;
};

/// By the values of a row in native byte order, at any address. Of pointers compilers make vectors.
template <class T>
void widen(T* low, T* high, const std::byte* row, std::size_t count) {
  for (std::size_t x = 0; x < count; ++x) {
    const T value = load<T>(row, x);
    // A comparison with not-a-number is false and keeps the end.
    low[x] = value < low[x] ? value : low[x];
    high[x] = value > high[x] ? value : high[x];
  }
}

int blocks_of(int voxels, int side) { return (voxels + side - 1) / side; }

}  // namespace

RangesOfBlocks::RangesOfBlocks(const SliceView& slice, const Shape& shape)
    : type_(slice.type),
      columns_(blocks_of(slice.width, shape.width)),
      rows_(blocks_of(slice.height, shape.height)) {
  visit_type(type_, [&](auto zero) {
    using T = decltype(zero);
    using Limits = std::numeric_limits<T>;
    // The ends of no values: low > high.
    constexpr T most = Limits::has_infinity ? Limits::infinity() : Limits::max();
    constexpr T least = Limits::has_infinity ? -Limits::infinity() : Limits::lowest();
    const auto width = std::size_t(slice.width);
    std::vector<Ends<T>> all;
    std::vector<T> low(width), high(width);
    for (int row = 0; row < rows_; ++row) {
      std::ranges::fill(low, most);
      std::ranges::fill(high, least);
      const int first = row * shape.height;
      for (int y = first; y < std::min(slice.height, first + shape.height + shape.beyond); ++y)
        widen(low.data(), high.data(), slice.values_of_row(y), width);
      for (int column = 0; column < columns_; ++column) {
        const int at = column * shape.width, end = std::min(slice.width, at + shape.width + shape.beyond);
        all.push_back({*std::min_element(low.begin() + at, low.begin() + end),
                       *std::max_element(high.begin() + at, high.begin() + end)});
      }
    }
    const auto bytes = std::as_bytes(std::span(all));
    ends_.assign(bytes.begin(), bytes.end());
  });
}

RangesOfBlocks::Range RangesOfBlocks::range(int column, int row) const {
  const std::size_t block = std::size_t(row) * std::size_t(columns_) + std::size_t(column);
  return visit_type(type_, [&](auto zero) {
    Ends<decltype(zero)> ends;
    std::memcpy(&ends, ends_.data() + block * sizeof ends, sizeof ends);
    return Range{static_cast<double>(ends.low), static_cast<double>(ends.high)};
  });
}

}  // namespace ringsplat
