#pragma once
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <limits>
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
inline std::uint64_t bytes_of_volumes(const std::filesystem::path& file, std::uint64_t bytes,
                                      std::uint64_t count, std::uint64_t before = 0) {
  constexpr auto most = std::uint64_t(std::numeric_limits<std::int64_t>::max());
  if (before > most || (count > 0 && bytes > (most - before) / count))
    refuse(file, "correct the sizes in the header", "{} volumes of {} bytes overflow 64 bits", count, bytes);
  return before + count * bytes;
}

/// Throws InputError unless `bytes` bytes from `offset` on fit into a file of `size`.
inline void require_bytes(const std::filesystem::path& file, std::uint64_t size, std::uint64_t offset,
                          std::uint64_t bytes) {
  if (size >= offset && size - offset >= bytes) return;
  refuse(file, "the file was cut short or its sizes are wrong",
         "the header promises {} bytes of voxels, the file holds {}", bytes,
         size > offset ? size - offset : 0);
}

/// Throws InputError when `available` compressed bytes cannot hold `bytes` bytes.
inline void require_compressed_bytes(const std::filesystem::path& file, std::uint64_t available,
                                     std::uint64_t bytes, std::uint64_t best_ratio) {
  if (bytes / best_ratio <= available) return;
  refuse(file, "the file was cut short or its sizes are wrong",
         "the header promises {} bytes of voxels, the file's {} compressed bytes "
         "cannot hold that many",
         bytes, available);
}

}  // namespace ringsplat::detail
