#pragma once
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {

/// Throws InputError: the file, what is wrong with it, and what to do.
template <class... Args>
[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& hint,
                         fmt::format_string<Args...> what, Args&&... args) {
  throw InputError(fmt::format("{}: {}", file.string(), fmt::format(what, std::forward<Args>(args)...)),
                   hint);
}

/// The most bytes that one compressed byte can hold: 1032 with deflate (zlib's technical page). Other coders'
/// limits only refuse claims that no real file makes.
inline constexpr std::uint64_t deflate_best_ratio = 1032;
inline constexpr std::uint64_t any_best_ratio = 100'000;

/// The bytes of `count` volumes of `bytes` bytes, and `before` others before them. Throws InputError when
/// they overflow 63 bits.
std::uint64_t bytes_of_volumes(const std::filesystem::path& file, std::uint64_t bytes, std::uint64_t count,
                               std::uint64_t before = 0);

/// Throws InputError unless `bytes` bytes from `offset` on fit into a file of `size`.
void require_bytes(const std::filesystem::path& file, std::uint64_t size, std::uint64_t offset,
                   std::uint64_t bytes);

/// Throws InputError when `available` compressed bytes cannot hold `bytes` bytes.
void require_compressed_bytes(const std::filesystem::path& file, std::uint64_t available, std::uint64_t bytes,
                              std::uint64_t best_ratio);

}  // namespace ringsplat::detail
