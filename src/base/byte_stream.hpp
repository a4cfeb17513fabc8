#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

/// Appends the object representation of `value`.
template <class T>
void append(Bytes& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto at = out.size();
  out.resize(at + sizeof(T));
  std::memcpy(out.data() + at, &value, sizeof(T));
}

/// Reads a T at `at` and moves `at` behind it; false when fewer than sizeof(T) bytes are left.
template <class T>
[[nodiscard]] bool take(std::span<const std::byte> in, std::size_t& at, T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (in.size() < at || in.size() - at < sizeof(T)) return false;
  std::memcpy(&value, in.data() + at, sizeof(T));
  at += sizeof(T);
  return true;
}

/// Appends the number of a vector's or string's values, then their object representations.
template <class Values>
void append_all(Bytes& out, const Values& values) {
  append(out, std::uint64_t(values.size()));
  for (const auto& value : values) append(out, value);
}

/// Reads what append_all wrote and moves `at` behind it; false when fewer bytes are left.
template <class Values>
[[nodiscard]] bool take_all(std::span<const std::byte> in, std::size_t& at, Values& values) {
  std::uint64_t count = 0;
  if (!take(in, at, count) || count > (in.size() - at) / sizeof(typename Values::value_type)) return false;
  values.resize(count);
  for (auto& value : values)
    if (!take(in, at, value)) return false;
  return true;
}

}  // namespace ringsplat
