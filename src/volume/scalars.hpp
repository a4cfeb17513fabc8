#pragma once
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// The i-th scalar of a row at any address.
template <class T>
T load(const std::byte* row, std::size_t i) {
  T value;
  std::memcpy(&value, row + sizeof(T) * i, sizeof(T));
  return value;
}

/// A comparison, so that compilers make vectors of loops.
template <class T>
bool is_finite(T value) {
  if constexpr (std::is_floating_point_v<T>)
    return std::abs(value) <= std::numeric_limits<T>::max();
  else
    return true;
}

/// Scalars that are aligned for their type.
template <class T>
std::span<const T> typed(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}
/// Calls f(span) with them.
template <class F>
void for_values(ScalarType type, std::span<const std::byte> bytes, F&& f) {
  visit_type(type, [&](auto zero) { f(typed<decltype(zero)>(bytes)); });
}

}  // namespace ringsplat
