#pragma once
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// Voxels first ... end - 1 along x, y, z.
struct VoxelBox {
  glm::ivec3 first{0}, end{0};
  glm::ivec3 dims() const { return end - first; }
  bool operator==(const VoxelBox&) const = default;
};

/// All of a volume's voxels.
inline VoxelBox whole_box(const Grid& grid) { return {glm::ivec3(0), grid.dims}; }

/// True when they have voxels in common.
inline bool meet(const VoxelBox& a, const VoxelBox& b) {
  return glm::all(glm::lessThan(a.first, b.end)) && glm::all(glm::lessThan(b.first, a.end));
}

/// Throws InputError that names the axis unless the box has voxels and lies within the volume.
void check(const VoxelBox& box, const Grid& grid);

/// The voxels of a coarser lattice of `level` voxels along the axes that hold a part of one of `finest`.
VoxelBox box_in_level(const VoxelBox& box, const glm::ivec3& finest, const glm::ivec3& level);

/// The lattice of the volume cropped to the box, left at its place in the world.
Grid clipped_grid(const Grid& grid, const VoxelBox& box);

}  // namespace ringsplat
