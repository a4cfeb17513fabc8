#include <fmt/format.h>

#include <cstring>

#include "ringsplat/base/error.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat {
namespace {

class MemorySource final : public VolumeSource {
 public:
  MemorySource(const Grid& grid, std::span<const std::byte> voxels) : grid_(grid), voxels_(voxels) {
    check(grid, "volume in memory");
    if (voxels.size() != grid.bytes())
      throw InputError(
          fmt::format("volume in memory: {} bytes given, {} x {} x {} {} needs {}", voxels.size(),
                      grid.dims.x, grid.dims.y, grid.dims.z, to_string(grid.type), grid.bytes()),
          "give exactly the voxels of the grid");
  }
  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return true; }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid_.slice_bytes(Axis::z);
    std::memcpy(out.data(), voxels_.data() + std::size_t(first) * bytes, std::size_t(count) * bytes);
  }

 private:
  Grid grid_;
  std::span<const std::byte> voxels_;
};

}  // namespace

std::unique_ptr<VolumeSource> memory_source(const Grid& grid, std::span<const std::byte> voxels) {
  return std::make_unique<MemorySource>(grid, voxels);
}

}  // namespace ringsplat
