#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "sheet_engine/slab_table.hpp"

namespace ringsplat {

/// Fills all entries of a table but their steepness and those on the diagonal, for slabs of `length` unit
/// lengths. The integrals over a slab are sums over four pieces between the curve's nodes; a piece's opacity
/// is exact, and its colour the mean of what emits in it.
void fill_slab_table(const SlabTable::Curve& curve, double length, std::span<std::uint64_t> entries);

/// A table entry without steepness. `opacity` above zero; colour straight, centroid and spread in [0, 1].
struct SlabEntry {
  double opacity, red, green, blue, centroid, spread;
};
std::uint64_t packed(const SlabEntry& entry);

/// Extinction of an opacity per unit length. That of opacity 1 would be infinite.
double extinction(double opacity);
/// The table entry of a uniform medium, without steepness.
std::uint64_t uniform_slab(double extinction, const glm::dvec3& colour, double length);

}  // namespace ringsplat
