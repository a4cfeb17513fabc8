#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>

#include "base/byte_order.hpp"

namespace ringsplat::detail {

/// Numbers at known places of a binary header, in either byte order.
class BinaryFields {
 public:
  /// `bytes` must outlive it.
  BinaryFields(std::span<const std::byte> bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

  /// `offset` + sizeof(T) must lie within the bytes.
  template <class T>
  T at(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> value{};
    std::copy_n(bytes_.begin() + std::ptrdiff_t(offset), sizeof(T), value.begin());
    to_native_order(value, sizeof(T), big_endian_);
    return std::bit_cast<T>(value);
  }

 private:
  std::span<const std::byte> bytes_;
  bool big_endian_;
};

}  // namespace ringsplat::detail
