#pragma once
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

/// The bytes that another rank sent are none that this build sends.
struct OtherBuild : RunError {
  explicit OtherBuild(const std::string& problem) : RunError(problem, "all ranks must run the same build") {}
};

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

}  // namespace ringsplat
