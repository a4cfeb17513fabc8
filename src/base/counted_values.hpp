#pragma once
#include <cstdint>
#include <span>

#include "base/byte_stream.hpp"
#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

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
