#include "formats/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "base/input_file.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {

std::uint64_t bytes_of_volumes(const std::filesystem::path& file, std::uint64_t bytes, std::uint64_t count,
                               std::uint64_t before) {
  constexpr auto most = std::uint64_t(std::numeric_limits<std::int64_t>::max());
  if (before > most || (count > 0 && bytes > (most - before) / count))
    throw InputError(fmt::format("{}: {} volumes of {} bytes overflow 64 bits", file.string(), count, bytes),
                     "correct the sizes in the header");
  return before + count * bytes;
}

void require_bytes(const std::filesystem::path& file, std::uint64_t size, std::uint64_t offset,
                   std::uint64_t bytes) {
  if (size >= offset && size - offset >= bytes) return;
  throw InputError(fmt::format("{}: the header promises {} bytes of voxels, the file holds {}", file.string(),
                               bytes, size > offset ? size - offset : 0),
                   "the file was cut short or its sizes are wrong");
}

void require_compressed_bytes(const std::filesystem::path& file, std::uint64_t available, std::uint64_t bytes,
                              std::uint64_t best_ratio) {
  if (bytes / best_ratio <= available) return;
  throw InputError(fmt::format("{}: the header promises {} bytes of voxels, the file's {} compressed bytes "
                               "cannot hold that many",
                               file.string(), bytes, available),
                   "the file was cut short or its sizes are wrong");
}

void require_numbers(const std::filesystem::path& file, std::uint64_t offset, std::uint64_t count,
                     std::uint64_t end) {
  const InputFile input(file);
  std::vector<std::byte> window(64 * 1024);
  std::uint64_t found = 0;
  bool in_word = false;
  while (found < count) {
    const auto wanted = std::min<std::uint64_t>(window.size(), end - std::min(end, offset));
    const auto got = input.read_some(offset, std::span(window).first(std::size_t(wanted)));
    if (got == 0)
      throw InputError(
          fmt::format("{}: the header promises {} numbers, the file holds {}", file.string(), count, found),
          "the file was cut short or its sizes are wrong");
    for (std::size_t i = 0; i < got; ++i) {
      const bool between = separates_numbers(char(window[i]));
      found += !between && !in_word;
      in_word = !between;
    }
    offset += got;
  }
}

}  // namespace ringsplat::detail
