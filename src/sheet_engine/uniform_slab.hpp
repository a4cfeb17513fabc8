#pragma once
#include <cstdint>
#include <glm/vec3.hpp>

namespace ringsplat {

/// Extinction of an opacity per unit length. That of opacity 1 would be infinite.
double extinction(double opacity);

/// The table entry of a uniform medium, without steepness.
std::uint64_t uniform_slab(double extinction, const glm::dvec3& colour, double length);

}  // namespace ringsplat
