#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

namespace ringsplat {

/// Bytes from a voxel to its neighbour along each axis, in any order; negative ones go backwards.
struct Strides {
  std::int64_t x = 0, y = 0, z = 0;
  bool operator==(const Strides&) const = default;
};

/// Of an array of `dims` voxels of `bytes` each without gaps: x the fastest (Fortran's order of an array (x,
/// y, z), C's of [z][y][x]), or z the fastest (C's order of an array [x][y][z]).
inline Strides x_fastest(const glm::ivec3& dims, std::size_t bytes) {
  const auto x = std::int64_t(bytes), y = x * dims.x;
  return {x, y, y * dims.y};
}
inline Strides z_fastest(const glm::ivec3& dims, std::size_t bytes) {
  const auto z = std::int64_t(bytes), y = z * dims.z;
  return {y * dims.y, y, z};
}

}  // namespace ringsplat
