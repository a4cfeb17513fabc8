#include "volume/clipped.hpp"

#include <fmt/format.h>

#include <cstring>
#include <utility>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat {
namespace {

class ClippedSource final : public ForwardingSource {
 public:
  ClippedSource(auto&& full, const Grid& grid, const VoxelBox& box)
      : ForwardingSource(std::forward<decltype(full)>(full), clipped_grid(grid, box)), box_(box) {}

  int layer_depth() const override { return 1; }  // layers begin anywhere
  void read_slices(int first, int count, std::span<std::byte> out) override {
    slice_.resize(source_.grid().slice_bytes(Axis::z));
    for (int k = 0; k < count; ++k) {
      source_.read_slices(box_.first.z + first + k, 1, slice_);
      copy_clipped(source_.grid(), box_, slice_.data(),
                   out.data() + std::size_t(k) * grid().slice_bytes(Axis::z));
    }
  }

 private:
  VoxelBox box_;
  std::vector<std::byte> slice_;  ///< of the whole volume
};

}  // namespace

void check(const VoxelBox& box, const Grid& grid) {
  for (const Axis axis : all_axes) {
    const int k = static_cast<int>(axis), first = box.first[k], end = box.end[k], last = grid.dims[k];
    if (0 <= first && first < end && end <= last) continue;
    throw InputError(fmt::format("the clip box's {} part, {}:{}, {}", name(axis), first, end,
                                 first < end ? fmt::format("does not lie within the volume's 0:{}", last)
                                             : "has no voxel"),
                     fmt::format("give 0 <= first < end <= {}", last));
  }
}

Grid clipped_grid(const Grid& grid, const VoxelBox& box) {
  Grid part = grid;
  part.dims = box.dims();
  part.origin += grid.direction * (grid.spacing * glm::dvec3(box.first));
  return part;
}

void copy_clipped(const Grid& grid, const VoxelBox& box, const std::byte* slice, std::byte* out) {
  const std::size_t scalar = size_of(grid.type), pitch = std::size_t(grid.dims.x) * scalar,
                    row = std::size_t(box.dims().x) * scalar;
  const std::byte* from = slice + std::size_t(box.first.y) * pitch + std::size_t(box.first.x) * scalar;
  for (int y = box.first.y; y < box.end.y; ++y, from += pitch, out += row) std::memcpy(out, from, row);
}

std::unique_ptr<VolumeSource> clipped_source(VolumeSource& full, const VoxelBox& box) {
  check(box, full.grid());
  return std::make_unique<ClippedSource>(full, full.grid(), box);
}

std::unique_ptr<VolumeSource> clipped_source(std::unique_ptr<VolumeSource> full, const VoxelBox& box) {
  const Grid grid = full->grid();
  check(box, grid);
  return std::make_unique<ClippedSource>(std::move(full), grid, box);
}

}  // namespace ringsplat
