#pragma once
#include <glm/vec3.hpp>

#include "truth/scene.hpp"

namespace ringsplat::truth {

/// A piece of a ray on which the value changes linearly, as its front sees it.
struct SlabIntegral {
  double opacity = 0;
  glm::dvec3 colour{0.0};  ///< straight; what lies in front hides what lies behind it
  /// Mean and standard deviation of the place, 0 at the front and 1 at the back, of what is seen: weighted by
  /// opacity and by the transmittance up to there.
  double centroid = 0.5, spread = 0;
};

/// Exact but for rounding: the slab is cut where its value crosses a point of the transfer function. Between
/// those the optical depth has a closed form, and all else is by parts an integral of 1 − transmittance.
/// `length` in unit lengths; `front` and `back` are numbers.
SlabIntegral integrate_slab(const TransferCurve& curve, double front, double back, double length);

}  // namespace ringsplat::truth
