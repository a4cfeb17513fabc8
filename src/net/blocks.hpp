#pragma once
#include <fmt/format.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "base/archive.hpp"
#include "net/collectives.hpp"

namespace ringsplat {

/// What every process hands in, on process 0; nothing elsewhere.
inline std::vector<Block> to_process_0(Collectives& collectives, Block mine) {
  std::vector<Block> out(std::size_t(collectives.processes()));
  out.front() = std::move(mine);
  std::vector<Block> in = collectives.all_to_all(std::move(out));
  if (collectives.process() != 0) in.clear();
  return in;
}

/// Reads back what to_bytes(values...) made. Throws RunError naming `what` when the block is none.
template <class... Values>
void read_block(const Block& block, const char* what, Values&... values) {
  FromBytes archive(block);
  archive(values...);
  if (!archive.ok() || !archive.at_end())
    throw OtherBuild(fmt::format("a process sent {} bytes instead of {}", block.size(), what));
}
template <class T>
T value_of(const Block& block, const char* what) {
  T value{};
  read_block(block, what, value);
  return value;
}

/// The next bytes of a message of voxels, and moves `at` behind them. Throws RunError when there are fewer.
inline std::span<const std::byte> next_bytes(std::span<const std::byte> in, std::size_t& at,
                                             std::size_t count) {
  if (in.size() - at < count) throw OtherBuild("a volume exchange message is too short");
  const auto part = in.subspan(at, count);
  at += count;
  return part;
}

/// The same of one value.
template <class T>
T next_value(std::span<const std::byte> in, std::size_t& at) {
  T value;
  std::memcpy(&value, next_bytes(in, at, sizeof(T)).data(), sizeof(T));
  return value;
}

}  // namespace ringsplat
