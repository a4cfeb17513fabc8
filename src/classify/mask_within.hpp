#pragma once
#include <cstddef>
#include <cstdint>

namespace ringsplat {

/// Bit i: the (first + i)-th scalar of a row at any address, less `low` and modulo the type's range, is at
/// most `span`. Of `count` scalars, up to 64; that many at once by vectors.
std::uint64_t mask_within(const std::byte* row, int first, int count, std::uint8_t low, std::uint8_t span);
std::uint64_t mask_within(const std::byte* row, int first, int count, std::uint16_t low, std::uint16_t span);

}  // namespace ringsplat
