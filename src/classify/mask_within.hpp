#pragma once
#include <cstddef>
#include <cstdint>

namespace ringsplat {

/// Bit i: scalar first + i of the row, minus `low` modulo the type's range, is at most `span`. For `count`
/// scalars, up to 64, at any address, by vectors.
std::uint64_t mask_within(const std::byte* row, int first, int count, std::uint8_t low, std::uint8_t span);
std::uint64_t mask_within(const std::byte* row, int first, int count, std::uint16_t low, std::uint16_t span);

}  // namespace ringsplat
