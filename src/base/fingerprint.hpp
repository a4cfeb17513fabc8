#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace ringsplat {

/// A 64-bit hash of bytes (FNV-1a; Fowler, Noll and Vo 1991). The same in every build and on every machine;
/// not cryptographic.
inline std::uint64_t fingerprint(std::span<const std::byte> bytes) {
  std::uint64_t value = 0xcbf29ce484222325;
  for (const std::byte byte : bytes) value = (value ^ std::to_integer<std::uint64_t>(byte)) * 0x100000001b3;
  return value;
}

}  // namespace ringsplat
