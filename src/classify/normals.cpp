#include "classify/normals.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "classify/normal_lattice.hpp"

namespace ringsplat {
namespace {

/// The direction's component along an axis with lattice coordinate `a` (0..1), for the common factor λ.
double unwarped(double a, double lambda) {
  return 0.5 * (std::sqrt(lattice_warp * lattice_warp + 4.0 * lambda * a) - lattice_warp);
}

/// The unit direction of face coordinates (a, b, c) that sum to one: the warp's inverse.
glm::dvec3 direction_of(const glm::dvec3& face) {
  // Bisects for the λ that makes the direction a unit vector; its length grows with λ.
  double low = lattice_warp + 1.0, high = lattice_warp * std::sqrt(3.0) + 1.0;
  glm::dvec3 n{};
  for (int round = 0; round < 60; ++round) {
    const double lambda = 0.5 * (low + high);
    n = {unwarped(face.x, lambda), unwarped(face.y, lambda), unwarped(face.z, lambda)};
    (glm::dot(n, n) < 1.0 ? low : high) = lambda;
  }
  return n / glm::length(n);
}

std::vector<glm::dvec3> make_directions() {
  std::vector<glm::dvec3> directions(normal_codes, glm::dvec3(0.0));
  for (int i = 0; i <= lattice_n; ++i)
    for (int j = 0; i + j <= lattice_n; ++j) {
      const int l = lattice_n - i - j;
      const glm::dvec3 n = direction_of(glm::dvec3(i, j, l) / double(lattice_n));
      for (int octant = 0; octant < 8; ++octant) {
        const bool west = octant & 1, south = octant & 2, lower = (octant & 4) && l > 0;
        directions[code_of(LatticePoint{west ? -i : i, south ? -j : j, lower})] = {
            west ? -n.x : n.x, south ? -n.y : n.y, lower ? -n.z : n.z};
      }
    }
  for (int first = 0; first < 3; ++first)
    for (int k = 0; k < points_between; ++k) {
      glm::dvec3 face(k + 0.5);
      face[(first + 2) % 3] = lattice_n - 1 - 2 * k;
      const glm::dvec3 n = direction_of(face / double(lattice_n));
      for (int octant = 0; octant < 8; ++octant)
        directions[code_of(PointBetween{first, octant, k})] = {
            octant & 1 ? -n.x : n.x, octant & 2 ? -n.y : n.y, octant & 4 ? -n.z : n.z};
    }
  return directions;
}

}  // namespace

NormalCode encode_normal(const glm::dvec3& direction) {
  const glm::dvec3 size = glm::abs(direction);
  if (!(std::isfinite(size.x) && std::isfinite(size.y) && std::isfinite(size.z))) return no_normal;
  const double largest = std::max({size.x, size.y, size.z});
  if (!(largest > 0)) return no_normal;
  const int exponent = std::ilogb(largest);
  if (exponent > -300 && exponent < 300) return encode_moderate(direction.x, direction.y, direction.z);
  return encode_moderate(std::scalbn(direction.x, -exponent), std::scalbn(direction.y, -exponent),
                         std::scalbn(direction.z, -exponent));
}

glm::dvec3 decode_normal(NormalCode code) {
  static const std::vector<glm::dvec3> directions = make_directions();
  return directions[code];
}

}  // namespace ringsplat
