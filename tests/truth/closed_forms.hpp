#pragma once
// Closed forms along a pixel's ray: unit lengths inside a shape, or the integral of a field.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "truth/ray.hpp"

namespace ringsplat::truth {

/// A pixel's ray in the unit cube: origin + s · step, s in unit lengths (the smallest spacing).
struct CubeRay {
  glm::dvec3 origin, step;
};
inline CubeRay cube_ray(const Scene& scene, Pixel pixel) {
  const LatticeRay ray = Rays(scene).through(pixel);
  const glm::dvec3 dims(scene.grid.dims);
  return {(ray.origin + 0.5) / dims, ray.step / dims};
}

/// The first and last s at which the ray is in the box low ≤ p ≤ high; first > last when it misses.
struct Span {
  double first = -std::numeric_limits<double>::infinity(), last = std::numeric_limits<double>::infinity();
};
inline Span inside_box(const CubeRay& ray, const glm::dvec3& low, const glm::dvec3& high) {
  Span span;
  for (int k = 0; k < 3; ++k) {
    if (ray.step[k] == 0) {
      if (ray.origin[k] < low[k] || ray.origin[k] > high[k]) return {1, 0};
      continue;
    }
    const double a = (low[k] - ray.origin[k]) / ray.step[k], b = (high[k] - ray.origin[k]) / ray.step[k];
    span.first = std::max(span.first, std::min(a, b));
    span.last = std::min(span.last, std::max(a, b));
  }
  return span;
}

inline double length_in_box(const CubeRay& ray, const glm::dvec3& low, const glm::dvec3& high) {
  const Span span = inside_box(ray, low, high);
  return std::max(0.0, span.last - span.first);
}

inline double length_in_ball(const CubeRay& ray, const glm::dvec3& centre, double radius) {
  const glm::dvec3 from = ray.origin - centre;
  const double a = glm::dot(ray.step, ray.step), s = -glm::dot(from, ray.step) / a;
  const glm::dvec3 nearest = from + s * ray.step;
  const double rest = radius * radius - glm::dot(nearest, nearest);
  return rest > 0 ? 2 * std::sqrt(rest / a) : 0.0;
}

/// The integral of exp(−|p − centre|² / (2 sigma²)) over the part of the ray in the unit cube.
inline double integral_of_gaussian(const CubeRay& ray, const glm::dvec3& centre, double sigma) {
  const Span span = inside_box(ray, glm::dvec3(0.0), glm::dvec3(1.0));
  if (!(span.first < span.last)) return 0;
  const glm::dvec3 from = ray.origin - centre;
  const double a = glm::dot(ray.step, ray.step), s = -glm::dot(from, ray.step) / a;
  const glm::dvec3 nearest = from + s * ray.step;
  const double rate = std::sqrt(a / 2) / sigma;
  return std::exp(-glm::dot(nearest, nearest) / (2 * sigma * sigma)) * std::sqrt(std::numbers::pi) /
         (2 * rate) * (std::erf(rate * (span.last - s)) - std::erf(rate * (span.first - s)));
}

}  // namespace ringsplat::truth
