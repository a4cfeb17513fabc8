#pragma once
#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace ringsplat {

/// Single voxels' values, evenly spread over a volume: what every rank knows of it, to foresee what its parts
/// will cost. No picture shows them.
struct VolumeSketch {
  static constexpr int most = 48;  ///< points along an axis

  glm::ivec3 dims{0};         ///< of the volume, in voxels
  glm::ivec3 points{0};       ///< along each axis
  std::vector<float> values;  ///< x fastest; not-a-number where it is the volume's

  VolumeSketch() = default;
  explicit VolumeSketch(const glm::ivec3& volume) : dims(volume) {
    for (int axis = 0; axis < 3; ++axis) points[axis] = std::min(dims[axis], most);
    values.resize(std::size_t(points.x) * std::size_t(points.y) * std::size_t(points.z));
  }
  /// The voxel of a point along an axis.
  int voxel(int axis, int point) const {
    return int((2 * std::int64_t(point) + 1) * dims[axis] / (2 * std::int64_t(points[axis])));
  }
  std::size_t index(const glm::ivec3& point) const {
    return (std::size_t(point.z) * std::size_t(points.y) + std::size_t(point.y)) * std::size_t(points.x) +
           std::size_t(point.x);
  }
};

}  // namespace ringsplat
