#include "formats/whole_source.hpp"

#include <cstring>
#include <utility>

namespace ringsplat::detail {

void WholeSource::read_slices(int first, int count, std::span<std::byte> out) {
  if (voxels_.empty()) {
    std::vector<std::byte> voxels(grid_.bytes());
    decode(voxels);
    voxels_ = std::move(voxels);
  }
  const auto bytes = grid_.slice_bytes(Axis::z);
  std::memcpy(out.data(), voxels_.data() + std::size_t(first) * bytes, std::size_t(count) * bytes);
}

}  // namespace ringsplat::detail
