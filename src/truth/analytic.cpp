#include "truth/analytic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>

#include "ringsplat/base/error.hpp"
#include "truth/parallel.hpp"
#include "truth/quadrature.hpp"
#include "truth/ray.hpp"
#include "truth/shading.hpp"
#include "truth/transfer_curve.hpp"

namespace ringsplat::truth {
namespace {

/// The first and last s at which the ray is in the box low ≤ p ≤ high; first > last when it misses.
struct Span {
  double first = -std::numeric_limits<double>::infinity(), last = std::numeric_limits<double>::infinity();
};
Span inside_box(const CubeRay& ray, const glm::dvec3& low, const glm::dvec3& high) {
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

CubeRay to_cube(const LatticeRay& ray, const Grid& grid) {
  const glm::dvec3 dims(grid.dims);
  return {(ray.origin + 0.5) / dims, ray.step / dims};
}

class FormulaIntegrator {
 public:
  FormulaIntegrator(const Scene& scene, Field field, double scale, double tolerance)
      : scene_(scene),
        field_(field),
        scale_(scale),
        tolerance_(tolerance),
        rays_(scene),
        curve_(scene.transfer_function),
        phong_(scene, rays_.view()) {
    const glm::dmat3 inverse = glm::inverse(scene.grid.direction);
    const glm::dvec3 size = scene.grid.spacing * glm::dvec3(scene.grid.dims);
    const double smallest = std::min({size.x, size.y, size.z});
    for (int k = 0; k < 3; ++k)
      against_gradient_[k] = -(smallest / size[k]) * glm::dvec3(inverse[0][k], inverse[1][k], inverse[2][k]);
  }

  Rgba along(Pixel pixel) const {
    const LatticeRay lattice_ray = rays_.through(pixel);
    if (!(lattice_ray.enter < lattice_ray.leave)) return Rgba(0.0);
    const CubeRay ray = to_cube(lattice_ray, scene_.grid);
    const auto medium_at = [&](double s) {
      const glm::dvec3 p = ray.origin + s * ray.step;
      const auto sample = curve_.at(scale_ * field_(p.x, p.y, p.z));
      Medium medium{extinction(sample.opacity), sample.colour};
      if (scene_.shaded && sample.opacity > 0)
        medium.colour = phong_.shade(medium.colour, normal(p), lattice_ray.to_viewer);
      return medium;
    };
    constexpr int pieces = 512;
    Piece seen;
    const double length = (lattice_ray.leave - lattice_ray.enter) / pieces;
    for (int i = 0; i < pieces && seen.transmittance >= 0.1 * tolerance_; ++i) {
      const double a = lattice_ray.enter + i * length;
      seen = behind(seen, integrate(medium_at, a, a + length, tolerance_ / pieces / seen.transmittance));
    }
    return Rgba(seen.colour, 1 - seen.transmittance);
  }

 private:
  glm::dvec3 normal(const glm::dvec3& p) const {
    constexpr double h = 1e-5;
    const glm::dvec3 difference{field_(p.x + h, p.y, p.z) - field_(p.x - h, p.y, p.z),
                                field_(p.x, p.y + h, p.z) - field_(p.x, p.y - h, p.z),
                                field_(p.x, p.y, p.z + h) - field_(p.x, p.y, p.z - h)};
    return against_gradient_ * difference;
  }

  const Scene& scene_;
  Field field_;
  double scale_, tolerance_;
  Rays rays_;
  TransferCurve curve_;
  Phong phong_;
  glm::dmat3 against_gradient_{1.0};
};

}  // namespace

std::vector<Rgba> analytic_truth(const Scene& scene, Field field, double scale, std::span<const Pixel> pixels,
                                 double tolerance) {
  check(scene.grid, "the reference's volume");
  check(scene.transfer_function, scene.transfer_function.name);
  if (!(tolerance > 0 && tolerance < 1))
    throw InputError(fmt::format("a tolerance of {} is not between 0 and 1", tolerance), "for instance 1e-6");
  if (scene.clip) check(*scene.clip, scene.grid);
  const FormulaIntegrator integrator(scene, field, scale, tolerance);
  std::vector<Rgba> colours(pixels.size());
  parallel_for(
      pixels.size(), 16,
      [&](std::size_t first, std::size_t end) {
        for (std::size_t p = first; p < end; ++p) colours[p] = integrator.along(pixels[p]);
      },
      scene.poll);
  return colours;
}

double synth_scale(ScalarType type) {
  return visit_type(type, [](auto zero) {
    using T = decltype(zero);
    return std::is_integral_v<T> ? static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
  });
}

CubeRay cube_ray(const Scene& scene, Pixel pixel) { return to_cube(Rays(scene).through(pixel), scene.grid); }

double length_in_box(const CubeRay& ray, const glm::dvec3& low, const glm::dvec3& high) {
  const Span span = inside_box(ray, low, high);
  return std::max(0.0, span.last - span.first);
}

double length_in_ball(const CubeRay& ray, const glm::dvec3& centre, double radius) {
  const glm::dvec3 from = ray.origin - centre;
  const double a = glm::dot(ray.step, ray.step), s = -glm::dot(from, ray.step) / a;
  const glm::dvec3 nearest = from + s * ray.step;
  const double rest = radius * radius - glm::dot(nearest, nearest);
  return rest > 0 ? 2 * std::sqrt(rest / a) : 0.0;
}

double integral_of_gaussian(const CubeRay& ray, const glm::dvec3& centre, double sigma) {
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
