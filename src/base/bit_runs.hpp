#pragma once
#include <bit>
#include <cstdint>

namespace ringsplat {

/// Calls use(first, count) for each run of set bits, lowest first.
template <class Use>
void for_each_bit_run(std::uint64_t bits, const Use& use) {
  for (int first = 0; bits != 0;) {
    const int skipped = std::countr_zero(bits), count = std::countr_one(bits >> skipped);
    first += skipped;
    use(first, count);
    first += count;
    // Shifts in two steps: shifting a 64-bit word by 64 is undefined.
    bits = bits >> skipped >> (count - 1) >> 1;
  }
}

}  // namespace ringsplat
