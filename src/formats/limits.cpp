#include "formats/limits.hpp"

#include <fmt/format.h>

#include <limits>

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

}  // namespace ringsplat::detail
