#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "ringsplat/base/error.hpp"
#include "ringsplat/view/view.hpp"
#include "view/matrices.hpp"

namespace ringsplat {
namespace {

Axis largest(const glm::dvec3& suits) {
  const double enough = largest_magnitude(suits) * (1.0 - 1e-9);
  for (const Axis axis : {Axis::z, Axis::y})
    if (std::abs(suits[int(axis)]) >= enough) return axis;
  return Axis::x;
}

/// Zeros for the axes along which the eye lies among the slices: some of its rays would meet them in one
/// order, some in the other.
glm::dvec3 in_one_order(glm::dvec3 suits, const glm::dvec3& eye, const glm::ivec3& dims) {
  bool outside = false;
  for (int k = 0; k < 3; ++k)
    if (eye[k] < -0.5 || eye[k] > dims[k] - 0.5)
      outside = true;
    else
      suits[k] = 0;
  if (!outside)
    throw InputError("the perspective camera's eye is inside the volume's box",
                     "move the --eye away, or use a larger --distance: above 1, in radii of the volume's "
                     "bounding sphere, the eye is outside from every side");
  return suits;
}

/// Zeros for the axes whose slices a ray crosses clearly less often than others'.
glm::dvec3 often_crossed(glm::dvec3 suits, const glm::dvec3& ray) {
  constexpr double clearly = 0.8;
  double most = 0;
  for (int k = 0; k < 3; ++k)
    if (suits[k] != 0) most = std::max(most, std::abs(ray[k]));
  for (int k = 0; k < 3; ++k)
    if (std::abs(ray[k]) < clearly * most) suits[k] = 0;
  return suits;
}

}  // namespace

Traversal choose_traversal(const ViewTransform& view, const LatticeFrame& lattice, SliceRule rule) {
  const glm::dmat3& linear = view.linear;
  const glm::dvec3 lengths{largest_magnitude(linear[0]), largest_magnitude(linear[1]),
                           largest_magnitude(linear[2])};
  // Columns of like size keep the determinant in range for spacings of 1e-12 or 1e12.
  const glm::dmat3 inverse =
      glm::inverse(glm::dmat3(linear[0] / lengths.x, linear[1] / lengths.y, linear[2] / lengths.z));
  glm::dvec3 ray{};         // lattice steps for one pixel of depth: which slices a ray crosses, and how fast
  glm::dvec3 cos_angles{};  // between the ray and each axis' slice normal, both on the screen; signed
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 normal{inverse[0][axis], inverse[1][axis], inverse[2][axis]};
    cos_angles[axis] = normal.z / glm::length(normal);
    ray[axis] = normal.z / lengths[axis];
  }
  glm::dvec3 suits = view.eye ? in_one_order(cos_angles, *view.eye, lattice.dims) : cos_angles;
  if (rule == SliceRule::most_crossed) suits = often_crossed(suits, ray);
  Traversal traversal;
  traversal.axis = largest(suits);
  const int k = int(traversal.axis);
  traversal.ascending = ray[k] > 0;
  traversal.cos_angle = std::abs(cos_angles[k]);
  const double unit_length = std::min({lattice.spacing.x, lattice.spacing.y, lattice.spacing.z});
  const glm::dvec3 step = ray / std::abs(ray[k]);  // between two neighbouring slices
  traversal.slice_distance = safe_length(lattice.direction * (lattice.spacing * step)) / unit_length;
  glm::dvec3 cells = ray / ray[k];
  cells[k] = 0;
  // Light changes along what does not bend.
  constexpr double least_bend = 0.6;
  const double bend = std::max(std::sqrt(largest_magnitude(cells)), least_bend);
  traversal.between = std::max(1.0, traversal.slice_distance / std::sqrt(3.0) * bend);
  return traversal;
}

}  // namespace ringsplat
