#include "volume/cell_ranges.hpp"

#include <cstring>
#include <limits>

#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

template <class T>
struct Ends {
  T low, high;
  void widen(const Ends& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
};

/// Of `count` values in native byte order, at any address; of none low > high.
template <class T>
Ends<T> ends_of(const std::byte* values, int count) {
  using Limits = std::numeric_limits<T>;
  Ends<T> ends{Limits::max(), Limits::lowest()};
  if constexpr (Limits::has_infinity) ends = {Limits::infinity(), -Limits::infinity()};
  for (int i = 0; i < count; ++i) {
    const T value = load<T>(values, std::size_t(i));
    // A comparison with not-a-number is false and keeps the end.
    ends.low = value < ends.low ? value : ends.low;
    ends.high = value > ends.high ? value : ends.high;
  }
  return ends;
}

int blocks_of(int voxels, int side) { return (voxels + side - 1) / side; }

}  // namespace

RangesOfBlocks::RangesOfBlocks(const SliceView& slice, const Shape& shape)
    : type_(slice.type),
      columns_(blocks_of(slice.width, shape.width)),
      rows_(blocks_of(slice.height, shape.height)) {
  visit_type(type_, [&](auto zero) {
    using T = decltype(zero);
    std::vector<Ends<T>> all(std::size_t(columns_) * std::size_t(rows_), ends_of<T>(nullptr, 0));
    for (int y = 0; y < slice.height; ++y)
      for (int column = 0; column < columns_; ++column) {
        const int first = column * shape.width;
        const Ends<T> here = ends_of<T>(slice.values_of_row(y) + std::size_t(first) * sizeof(T),
                                        std::min(shape.width + shape.beyond, slice.width - first));
        // A row behind a block is of the next one, too.
        for (int row = std::max(y - shape.beyond, 0) / shape.height; row <= y / shape.height; ++row)
          all[std::size_t(row) * std::size_t(columns_) + std::size_t(column)].widen(here);
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
