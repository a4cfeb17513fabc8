#pragma once
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>

#include "ringsplat/volume/source.hpp"

namespace ringsplat {

class MemorySource final : public VolumeSource {
 public:
  MemorySource(const Grid& grid, std::span<const std::byte> voxels) : grid_(grid), voxels_(voxels) {
    check(grid, "volume in memory");
    if (voxels.size() != grid.bytes()) throw std::invalid_argument("these are voxels of another grid");
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

/// A volume that lies in memory; `voxels` (grid.bytes() bytes, native order) must outlive the source.
inline std::unique_ptr<VolumeSource> memory_source(const Grid& grid, std::span<const std::byte> voxels) {
  return std::make_unique<MemorySource>(grid, voxels);
}

}  // namespace ringsplat
