#pragma once
#include <cstdint>
#include <filesystem>

namespace ringsplat::detail {

/// The most bytes that one compressed byte can hold: 1032 with deflate (zlib's technical page). Other coders'
/// limits only refuse claims that no real file makes.
inline constexpr std::uint64_t deflate_best_ratio = 1032;
inline constexpr std::uint64_t any_best_ratio = 100'000;

/// Throws InputError unless `bytes` bytes from `offset` on fit into a file of `size`.
void require_bytes(const std::filesystem::path& file, std::uint64_t size, std::uint64_t offset,
                   std::uint64_t bytes);

/// Throws InputError when `available` compressed bytes cannot hold `bytes` bytes.
void require_compressed_bytes(const std::filesystem::path& file, std::uint64_t available, std::uint64_t bytes,
                              std::uint64_t best_ratio);

/// Throws InputError unless `count` words separated by blanks follow in the text file from `offset` on.
void require_numbers(const std::filesystem::path& file, std::uint64_t offset, std::uint64_t count);

}  // namespace ringsplat::detail
