#include "volume/clipped.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <glm/common.hpp>
#include <utility>

#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

/// Every step-th voxel of a box.
class ClippedSource final : public ForwardingSource {
 public:
  ClippedSource(auto&& full, const Grid& part, const VoxelBox& box, int step = 1)
      : ForwardingSource(std::forward<decltype(full)>(full), part), box_(box), step_(step) {}

  /// Those of a box begin anywhere.
  int layer_depth() const override { return step_ == 1 ? 1 : std::max(1, source_.layer_depth() / step_); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    slice_.resize(source_.grid().slice_bytes(Axis::z));
    for (int k = 0; k < count; ++k) {
      source_.read_slices(box_.first.z + (first + k) * step_, 1, slice_);
      copy_clipped(source_.grid(), box_, slice_.data(),
                   out.data() + std::size_t(k) * grid().slice_bytes(Axis::z), step_);
    }
  }

 private:
  VoxelBox box_;
  int step_;
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

VoxelBox box_in_level(const VoxelBox& box, const glm::ivec3& finest, const glm::ivec3& level) {
  VoxelBox scaled;
  for (int k = 0; k < 3; ++k) {
    scaled.first[k] = int(std::int64_t(box.first[k]) * level[k] / finest[k]);
    scaled.end[k] = int((std::int64_t(box.end[k]) * level[k] + finest[k] - 1) / finest[k]);
  }
  return scaled;
}

VoxelBox box_in_finest(const VoxelBox& box, const glm::dvec3& each, const glm::ivec3& finest) {
  constexpr double rounding = 1e-6;
  return {glm::ivec3(glm::floor(glm::dvec3(box.first) * each + rounding)),
          glm::min(glm::ivec3(glm::ceil(glm::dvec3(box.end) * each - rounding)), finest)};
}

Grid clipped_grid(const Grid& grid, const VoxelBox& box) {
  Grid part = grid;
  part.dims = box.dims();
  part.origin += grid.direction * (grid.spacing * glm::dvec3(box.first));
  return part;
}

void copy_clipped(const Grid& grid, const VoxelBox& box, const std::byte* slice, std::byte* out, int step) {
  const std::size_t scalar = size_of(grid.type), pitch = std::size_t(grid.dims.x) * scalar;
  const int width = (box.dims().x + step - 1) / step;
  for (int y = box.first.y; y < box.end.y; y += step, out += std::size_t(width) * scalar)
    copy_row(scalar, slice + std::size_t(y) * pitch + std::size_t(box.first.x) * scalar,
             std::int64_t(scalar) * step, width, out);
}

std::unique_ptr<VolumeSource> clipped_source(VolumeSource& full, const VoxelBox& box) {
  check(box, full.grid());
  return std::make_unique<ClippedSource>(full, clipped_grid(full.grid(), box), box);
}

std::unique_ptr<VolumeSource> clipped_source(std::unique_ptr<VolumeSource> full, const VoxelBox& box) {
  const Grid grid = full->grid();
  check(box, grid);
  return std::make_unique<ClippedSource>(std::move(full), clipped_grid(grid, box), box);
}

std::unique_ptr<VolumeSource> skipping_source(std::unique_ptr<VolumeSource> full, const Grid& reduced,
                                              int step) {
  const VoxelBox whole = whole_box(full->grid());
  return std::make_unique<ClippedSource>(std::move(full), reduced, whole, step);
}

}  // namespace ringsplat
