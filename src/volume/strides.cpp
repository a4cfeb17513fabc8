#include "ringsplat/volume/strides.hpp"

namespace ringsplat {

Strides x_fastest(const glm::ivec3& dims, std::size_t bytes) {
  const auto x = std::int64_t(bytes), y = x * dims.x;
  return {x, y, y * dims.y};
}

Strides z_fastest(const glm::ivec3& dims, std::size_t bytes) {
  const auto z = std::int64_t(bytes), y = z * dims.z;
  return {y * dims.y, y, z};
}

}  // namespace ringsplat
