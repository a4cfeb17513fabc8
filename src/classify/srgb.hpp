#pragma once
#include <cmath>
#include <glm/vec3.hpp>

namespace ringsplat {

/// Display value to linear light, both 0..1 (IEC 61966-2-1:1999).
inline double srgb_to_linear(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
inline double linear_to_srgb(double v) {
  return v <= 0.0031308 ? v * 12.92 : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
}
inline glm::dvec3 srgb_to_linear(const glm::dvec3& c) {
  return {srgb_to_linear(c.x), srgb_to_linear(c.y), srgb_to_linear(c.z)};
}
inline glm::dvec3 linear_to_srgb(const glm::dvec3& c) {
  return {linear_to_srgb(c.x), linear_to_srgb(c.y), linear_to_srgb(c.z)};
}

}  // namespace ringsplat
