#pragma once
#include <glm/vec3.hpp>

namespace ringsplat {

/// Voxels first ... end - 1 along x, y, z.
struct VoxelBox {
  glm::ivec3 first{0}, end{0};
  bool operator==(const VoxelBox&) const = default;
};

}  // namespace ringsplat
