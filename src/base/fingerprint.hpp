#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace ringsplat {

/// A 64-bit hash of bytes (FNV-1a; Fowler, Noll and Vo 1991). The same in every build and on every machine;
/// not cryptographic.
class Fingerprint {
 public:
  void add(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) value_ = (value_ ^ std::to_integer<std::uint64_t>(byte)) * prime;
  }
  void add(const std::string& text) { add(std::as_bytes(std::span(text))); }
  std::uint64_t value() const { return value_; }

 private:
  static constexpr std::uint64_t prime = 0x100000001b3;
  std::uint64_t value_ = 0xcbf29ce484222325;
};

}  // namespace ringsplat
