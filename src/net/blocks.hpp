#pragma once
#include <fmt/format.h>

#include <span>

#include "base/byte_stream.hpp"
#include "net/collectives.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

inline Block block_of(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

/// The object representation of a value, for processes of one build.
template <class T>
Block block_of_value(const T& value) {
  return block_of(std::as_bytes(std::span(&value, 1)));
}

/// Reads the value back. Throws RunError naming `what` when the block has another size.
template <class T>
T value_of(const Block& block, const char* what) {
  T value;
  std::size_t at = 0;
  if (!take(block, at, value) || at != block.size())
    throw RunError(fmt::format("a process sent {} bytes instead of {}", block.size(), what),
                   "all ranks must run the same build");
  return value;
}

}  // namespace ringsplat
