#pragma once
#include <type_traits>

#include "classify/mask_where.hpp"

namespace ringsplat {

/// Bit i: values[i] − low, modulo the type's range, is at most span. `values`: 64 numbers at any address.
std::uint64_t mask_within(const std::byte* values, std::uint8_t low, std::uint8_t span);
std::uint64_t mask_within(const std::byte* values, std::uint16_t low, std::uint16_t span);

/// for_each_mask for scalars that lie so: whole blocks by vectors.
template <class Bits, class Take>
void for_each_mask_within(const std::byte* row, int first, int end, Bits low, Bits span, const Take& take) {
  const auto lies_within = [low, span](Bits bits) { return std::uint8_t(Bits(bits - low) <= span); };
  while (first < end) {
    const int block = first / mask_bits * mask_bits, next = std::min(block + mask_bits, end);
    const std::uint64_t mask = next - first == mask_bits
                                   ? mask_within(row + sizeof(Bits) * std::size_t(first), low, span)
                                   : mask_where<Bits>(row, first, next - first, lies_within)
                                         << (first - block);
    if (mask != 0) take(block, mask);
    first = next;
  }
}

}  // namespace ringsplat
