#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "ringsplat/truth/scene.hpp"

namespace ringsplat::truth {

/// A pixel's ray in lattice coordinates, by unit lengths: point s is origin + s · step. It enters the box of
/// the voxels' faces, [−½, n − ½] along each axis, at `enter` and leaves it at `leave`; enter ≥ leave when it
/// misses.
struct LatticeRay {
  glm::dvec3 origin, step;
  double enter = 0, leave = 0;
  glm::dvec3 at(double s) const { return origin + s * step; }
};

/// Rays of one view.
class Rays {
 public:
  explicit Rays(const Scene& scene);
  LatticeRay through(Pixel pixel) const;
  const ViewTransform& view() const { return view_; }

 private:
  ViewTransform view_;
  glm::dmat3 to_lattice_{1.0};
  glm::dvec3 step_{0.0}, dims_{1.0};
};

/// Extinction of opacity `opacity` per unit length: infinite for 1.
double extinction(double opacity);

}  // namespace ringsplat::truth
