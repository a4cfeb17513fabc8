#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace ringsplat {

/// The i-th scalar of a row at any address.
template <class T>
T load(const std::byte* row, int i) {
  T value;
  std::memcpy(&value, row + sizeof(T) * std::size_t(i), sizeof(T));
  return value;
}

inline constexpr int mask_bits = 64;

/// Bit i: flags[i], each 0 or 1. Eight bytes at a time go to eight bits by one product, none of whose terms
/// meet.
inline std::uint64_t to_mask(const std::array<std::uint8_t, mask_bits>& flags) {
  constexpr std::uint64_t gather =
      std::endian::native == std::endian::little ? 0x0102040810204080 : 0x8040201008040201;
  std::uint64_t mask = 0;
  for (int i = 0; i < mask_bits; i += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, flags.data() + i, sizeof eight);
    mask |= (eight * gather) >> 56 << i;
  }
  return mask;
}

/// Which of the up to 64 scalars from the `first` on satisfy `wanted`, which gives 0 or 1 and is asked for
/// all without a branch; so it may also be asked for zeros.
template <class T, class Wanted>
std::uint64_t mask_where(const std::byte* row, int first, int count, const Wanted& wanted) {
  std::array<T, mask_bits> values;
  const std::byte* from = row + sizeof(T) * std::size_t(first);
  if (count == mask_bits) {
    std::memcpy(values.data(), from, sizeof values);
  } else {
    values.fill(T{});
    std::memcpy(values.data(), from, sizeof(T) * std::size_t(count));
  }
  std::array<std::uint8_t, mask_bits> flags;
  for (std::size_t i = 0; i < mask_bits; ++i) flags[i] = wanted(values[i]);
  const std::uint64_t mask = to_mask(flags);
  return count == mask_bits ? mask : mask & ((std::uint64_t{1} << count) - 1);
}

/// Calls take(block, mask) for the blocks of mask_bits columns, which begin at multiples of that, with
/// columns among first … end − 1 that are wanted, ascending. Bit i of the mask, which is not 0, is column
/// block + i. mask_of(first, count): of the up to 64 columns from the `first` on, which lie in one block.
template <class MaskOf, class Take>
void for_each_mask(int first, int end, const MaskOf& mask_of, const Take& take) {
  while (first < end) {
    const int block = first / mask_bits * mask_bits, next = std::min(block + mask_bits, end);
    const std::uint64_t mask = mask_of(first, next - first) << (first - block);
    if (mask != 0) take(block, mask);
    first = next;
  }
}

}  // namespace ringsplat
