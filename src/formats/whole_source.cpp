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

Facts WholeFileSource::facts() const {
  Facts facts = files_.facts();
  facts.insert(facts.begin(), {"encoding", "decoded as a whole"});
  return facts;
}

void WholeFileSource::decode(std::span<std::byte> voxels) {
  files_.require_unchanged(path_);
  decode_file(voxels);
  files_.require_unchanged(path_);
}

}  // namespace ringsplat::detail
