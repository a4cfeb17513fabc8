#include "formats/limits.hpp"

#include <limits>

namespace ringsplat::detail {

std::uint64_t bytes_of_volumes(const std::filesystem::path& file, std::uint64_t bytes, std::uint64_t count,
                               std::uint64_t before) {
  constexpr auto most = std::uint64_t(std::numeric_limits<std::int64_t>::max());
  if (before > most || (count > 0 && bytes > (most - before) / count))
    refuse(file, "correct the sizes in the header", "{} volumes of {} bytes overflow 64 bits", count, bytes);
  return before + count * bytes;
}

void require_bytes(const std::filesystem::path& file, std::uint64_t size, std::uint64_t offset,
                   std::uint64_t bytes) {
  if (size >= offset && size - offset >= bytes) return;
  refuse(file, "the file was cut short or its sizes are wrong",
         "the header promises {} bytes of voxels, the file holds {}", bytes,
         size > offset ? size - offset : 0);
}

void require_compressed_bytes(const std::filesystem::path& file, std::uint64_t available, std::uint64_t bytes,
                              std::uint64_t best_ratio) {
  if (bytes / best_ratio <= available) return;
  refuse(file, "the file was cut short or its sizes are wrong",
         "the header promises {} bytes of voxels, the file's {} compressed bytes "
         "cannot hold that many",
         bytes, available);
}

}  // namespace ringsplat::detail
