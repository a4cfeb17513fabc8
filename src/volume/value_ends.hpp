#pragma once
#include <cstddef>
#include <cstring>
#include <limits>

namespace ringsplat {

/// The smallest and the largest of some values, infinities included. Not-a-number is ignored.
template <class T>
struct ValueEnds {
  T low, high;
};

/// The ends of no values: low > high.
template <class T>
constexpr ValueEnds<T> no_values() {
  using Limits = std::numeric_limits<T>;
  if constexpr (Limits::has_infinity)
    return {Limits::infinity(), -Limits::infinity()};
  else
    return {Limits::max(), Limits::min()};
}

/// Widens `ends` by `count` values in native byte order, at any address.
template <class T>
void widen(ValueEnds<T>& ends, const std::byte* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, values + i * sizeof(T), sizeof(T));
    // A comparison with not-a-number is false and keeps the end.
    ends.low = value < ends.low ? value : ends.low;
    ends.high = value > ends.high ? value : ends.high;
  }
}

}  // namespace ringsplat
