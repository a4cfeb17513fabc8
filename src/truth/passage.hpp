#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "truth/ray.hpp"
#include "truth/series.hpp"

namespace ringsplat::truth {

/// A ray that is computed in doubles lies this near to the exact one, in voxels (docs/certified.md, 1).
inline constexpr double tube = 1e-10;

/// So slow along an axis, a ray may run along voxels' faces: where it crosses them is not known.
inline bool may_run_along_faces(double step) {
  constexpr double slowest = 1e-5;
  return std::abs(step) < slowest;
}

/// A place along a ray, and how uncertain it is.
struct Uncertain {
  double at, by;
  Interval exact() const { return Interval(at) + within(by); }
};

/// Where a ray crosses planes between voxels, and enters and leaves the volume (docs/certified.md, 2).
std::vector<Uncertain> uncertain_cuts(const Scene& scene, const LatticeRay& ray);

/// A crossing, with what is known of the exact ray's.
struct Passage : Crossing {
  Interval length;                       ///< of the exact ray's passage, from 0
  std::array<Interval, 3> from, change;  ///< place in the cell, 0 to 1 along each axis, and along the passage
  double beside = 0;                     ///< how far the exact ray may be outside of it
};

Passage passage_between(const Scene& scene, const LatticeRay& ray, const Uncertain& enter,
                        const Uncertain& leave);

/// Interpolation between a cell's corners as a polynomial of the part of the passage.
Polynomial along_passage(const Corners<Interval>& corners, const Passage& passage);

}  // namespace ringsplat::truth
