#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace ringsplat {

inline constexpr int mask_bits = 64;

/// Bit i is flags[i], each 0 or 1. One multiplication turns eight bytes into eight bits; its partial products
/// do not overlap.
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

/// Mask of the up to 64 scalars from `first` on that satisfy `wanted`, which returns 0 or 1. Without a
/// branch: `wanted` is called for all places, also for zeros beyond the last scalar.
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

/// Calls take(block, mask), ascending, for each aligned block of mask_bits columns that has a wanted column
/// among first … end − 1. Bit i of the mask is column block + i. mask_of(first, count) must return the mask
/// of up to 64 columns from `first` on, all in one block.
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
