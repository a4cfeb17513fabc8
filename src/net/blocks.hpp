#pragma once
#include <fmt/format.h>

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/byte_stream.hpp"
#include "net/collectives.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

/// What every process hands in, on process 0.
inline std::vector<Block> to_process_0(Collectives& collectives, Block mine) {
  std::vector<Block> out(std::size_t(collectives.processes()));
  out.front() = std::move(mine);
  return collectives.all_to_all(std::move(out));
}

inline Block block_of(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

inline Block block_of_text(const std::string& text) { return block_of(std::as_bytes(std::span(text))); }
inline std::string text_of(const Block& block) {
  return {reinterpret_cast<const char*>(block.data()), block.size()};
}

/// The object representation of a value.
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

/// The next bytes of a message of voxels, and moves `at` behind them. Throws RunError when there are fewer.
inline std::span<const std::byte> next_bytes(std::span<const std::byte> in, std::size_t& at,
                                             std::size_t count) {
  if (in.size() - at < count)
    throw RunError("a volume exchange message is too short", "all ranks must run the same build");
  const auto part = in.subspan(at, count);
  at += count;
  return part;
}

/// The same of one value.
template <class T>
T next_value(std::span<const std::byte> in, std::size_t& at) {
  const auto bytes = next_bytes(in, at, sizeof(T));
  T value;
  std::size_t begin = 0;
  static_cast<void>(take(bytes, begin, value));
  return value;
}

}  // namespace ringsplat
