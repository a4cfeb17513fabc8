#include "ringsplat/volume/voxel_box.hpp"

#include <fmt/format.h>

#include "ringsplat/base/error.hpp"

namespace ringsplat {

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

}  // namespace ringsplat
