#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>
#include <type_traits>

namespace ringsplat::detail {

/// Converts scalars of `scalar_bytes` bytes from the given byte order to the machine's.
inline void to_native_order(std::span<std::byte> values, std::size_t scalar_bytes, bool big_endian) {
  if (scalar_bytes < 2 || big_endian == (std::endian::native == std::endian::big)) return;
  const auto swap = [values](auto size) {
    for (std::size_t i = 0; i + size() <= values.size(); i += size())
      std::reverse(values.begin() + std::ptrdiff_t(i), values.begin() + std::ptrdiff_t(i + size()));
  };
  if (scalar_bytes == 2) swap(std::integral_constant<std::size_t, 2>{});
  if (scalar_bytes == 4) swap(std::integral_constant<std::size_t, 4>{});
  if (scalar_bytes == 8) swap(std::integral_constant<std::size_t, 8>{});
}

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
