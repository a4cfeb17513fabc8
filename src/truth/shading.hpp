#pragma once
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "truth/scene.hpp"

namespace ringsplat::truth {

/// Phong's reflection (Phong 1975) as the renderer defines it: white light, two-sided, colours clamped to 1;
/// a zero normal leaves the colour as it is.
class Phong {
 public:
  Phong(const Scene& scene, const ViewTransform& view);
  /// What light makes of a colour: colour · scale + highlight, at most 1.
  struct Light {
    double scale = 1, highlight = 0;
    glm::dvec3 on(const glm::dvec3& colour) const { return glm::min(colour * scale + highlight, 1.0); }
  };
  /// `normal`: of any length. `to_viewer`: a world direction of unit length.
  Light light(const glm::dvec3& normal, const glm::dvec3& to_viewer) const;
  glm::dvec3 shade(const glm::dvec3& colour, const glm::dvec3& normal, const glm::dvec3& to_viewer) const {
    return light(normal, to_viewer).on(colour);
  }
  const glm::dvec3& to_light() const { return to_light_; }

 private:
  PhongMaterial material_;
  glm::dvec3 to_light_;
};

/// From differences along the axes of a lattice, or of any box, to a world direction against the gradient, up
/// to one common factor. `size`: of a step along each axis.
glm::dmat3 against_gradient(const glm::dmat3& direction, const glm::dvec3& size);

/// Central differences of the voxels, against the gradient, in world directions, up to one common factor.
class Gradients {
 public:
  explicit Gradients(const Scene& scene);
  /// One-sided at the border and beside a value that is not finite; zero where the voxel itself is not
  /// finite.
  glm::dvec3 at(const glm::ivec3& voxel) const;

 private:
  const Scene& scene_;
  glm::dmat3 to_world_;    ///< from differences along the lattice axes
  long double scale_ = 1;  ///< brings the values near 1: their differences may be beyond double's range
};

}  // namespace ringsplat::truth
