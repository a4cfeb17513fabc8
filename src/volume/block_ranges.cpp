#include "ringsplat/volume/block_ranges.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

namespace ringsplat {
namespace {

template <class T>
struct Ends {
  T low, high;
};

template <class T>
constexpr Ends<T> nothing() {
  using Limits = std::numeric_limits<T>;
  if constexpr (Limits::has_infinity)
    return {Limits::infinity(), -Limits::infinity()};
  else
    return {Limits::max(), Limits::min()};
}

template <class T>
void widen(Ends<T>& ends, const std::byte* values, int count) {
  for (int i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, values + std::size_t(i) * sizeof(T), sizeof(T));
    // A comparison with not-a-number is false and keeps the end.
    ends.low = value < ends.low ? value : ends.low;
    ends.high = value > ends.high ? value : ends.high;
  }
}

}  // namespace

BlockRanges::BlockRanges(const SliceView& slice)
    : type_(slice.type),
      columns_((slice.width + block_width - 1) / block_width),
      rows_((slice.height + block_height - 1) / block_height) {
  visit_type(type_, [&](auto zero) {
    using T = decltype(zero);
    std::vector<Ends<T>> ends(std::size_t(columns_) * std::size_t(rows_), nothing<T>());
    for (int y = 0; y < slice.height; ++y) {
      const std::byte* row = slice.values_of_row(y);
      for (int column = 0; column < columns_; ++column) {
        const int first = column * block_width;
        widen(ends[std::size_t(y / block_height) * std::size_t(columns_) + std::size_t(column)],
              row + std::size_t(first) * sizeof(T), std::min(block_width, slice.width - first));
      }
    }
    ranges_.resize(ends.size() * sizeof(Ends<T>));
    std::memcpy(ranges_.data(), ends.data(), ranges_.size());
  });
}

BlockRanges::Range BlockRanges::range(int column, int row) const {
  return visit_type(type_, [&](auto zero) {
    using T = decltype(zero);
    Ends<T> ends;
    std::memcpy(
        &ends,
        ranges_.data() + (std::size_t(row) * std::size_t(columns_) + std::size_t(column)) * sizeof ends,
        sizeof ends);
    return Range{static_cast<double>(ends.low), static_cast<double>(ends.high)};
  });
}

}  // namespace ringsplat
