#pragma once
#include <bit>
#include <cstdint>

namespace ringsplat {

/// Calls use(first, count) for each run of bits that are set, from the lowest on.
template <class Use>
void for_each_bit_run(std::uint64_t bits, const Use& use) {
  for (int first = 0; bits != 0;) {
    const int skipped = std::countr_zero(bits), count = std::countr_one(bits >> skipped);
    first += skipped;
    use(first, count);
    first += count;
    // In two steps, since a shift by all 64 bits is none.
    bits = bits >> skipped >> (count - 1) >> 1;
  }
}

}  // namespace ringsplat
