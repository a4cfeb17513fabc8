#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// Whether values are whole numbers.
constexpr bool is_whole(ScalarType type) {
  return type != ScalarType::float32 && type != ScalarType::float64;
}

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

/// Copies a row of `count` scalars, which lie `stride` bytes apart and need not be aligned, to one without
/// gaps.
template <std::size_t bytes>
void copy_row(const std::byte* from, std::int64_t stride, int count, std::byte* to) {
  if (stride == std::int64_t(bytes)) {
    std::memcpy(to, from, bytes * std::size_t(count));
    return;
  }
  for (int k = 0; k < count; ++k, from += stride, to += bytes) std::memcpy(to, from, bytes);
}

inline void copy_row(std::size_t bytes, const std::byte* from, std::int64_t stride, int count,
                     std::byte* to) {
  if (bytes == 1) return copy_row<1>(from, stride, count, to);
  if (bytes == 2) return copy_row<2>(from, stride, count, to);
  if (bytes == 4) return copy_row<4>(from, stride, count, to);
  copy_row<8>(from, stride, count, to);
}

}  // namespace ringsplat
