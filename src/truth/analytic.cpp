#include "truth/analytic.hpp"

#include <limits>

#include "truth/quadrature.hpp"
#include "truth/ray.hpp"
#include "truth/shading.hpp"
#include "truth/transfer_curve.hpp"

namespace ringsplat::truth {
namespace {

class FormulaIntegrator {
 public:
  FormulaIntegrator(const Scene& scene, Field field, double scale, double tolerance)
      : scene_(scene),
        field_(field),
        scale_(scale),
        tolerance_(tolerance),
        rays_(scene),
        curve_(scene.transfer_function),
        phong_(scene, rays_.view()),
        against_gradient_(
            against_gradient(scene.grid.direction, scene.grid.spacing * glm::dvec3(scene.grid.dims))) {}

  Rgba along(Pixel pixel) const {
    const LatticeRay lattice_ray = rays_.through(pixel);
    if (!(lattice_ray.enter < lattice_ray.leave)) return Rgba(0.0);
    const glm::dvec3 dims(scene_.grid.dims), origin = (lattice_ray.origin + 0.5) / dims,
                                             step = lattice_ray.step / dims;
    const auto medium_at = [&](double s) {
      const glm::dvec3 p = origin + s * step;
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
  glm::dmat3 against_gradient_;
};

}  // namespace

std::vector<Rgba> analytic_truth(const Scene& scene, Field field, double scale, std::span<const Pixel> pixels,
                                 double tolerance) {
  check(scene.grid, "the reference's volume");
  check(scene.transfer_function, scene.transfer_function.name);
  if (scene.clip) check(*scene.clip, scene.grid);
  const FormulaIntegrator integrator(scene, field, scale, tolerance);
  return along_rays(scene, pixels, [&](Pixel pixel) { return integrator.along(pixel); });
}

double synth_scale(ScalarType type) {
  return visit_type(type, [](auto zero) {
    using T = decltype(zero);
    return std::is_integral_v<T> ? static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
  });
}

}  // namespace ringsplat::truth
