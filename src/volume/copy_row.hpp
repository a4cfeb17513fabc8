#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace ringsplat {

/// Copies a row of `count` scalars, which lie `stride` bytes apart and need not be aligned, to one without
/// gaps.
template <std::size_t bytes>
void copy_row(const std::byte* from, std::int64_t stride, int count, std::byte* to) {
  if (stride == std::int64_t(bytes)) {
    std::memcpy(to, from, bytes * std::size_t(count));
    return;
  }
  for (int k = 0; k < count; ++k, from += stride, to += bytes) std::memcpy(to, from, bytes);
}

inline void copy_row(std::size_t bytes, const std::byte* from, std::int64_t stride, int count,
                     std::byte* to) {
  if (bytes == 1) return copy_row<1>(from, stride, count, to);
  if (bytes == 2) return copy_row<2>(from, stride, count, to);
  if (bytes == 4) return copy_row<4>(from, stride, count, to);
  copy_row<8>(from, stride, count, to);
}

}  // namespace ringsplat
