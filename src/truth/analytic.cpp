#include <limits>

#include "truth/field.hpp"
#include "truth/quadrature.hpp"
#include "truth/ray.hpp"

namespace ringsplat::truth {

std::vector<Rgba> analytic_truth(const Scene& scene, Field field, double scale, std::span<const Pixel> pixels,
                                 double tolerance) {
  const Shown& shown = scene.frame.shown;
  if (shown.clip) check(*shown.clip, scene.grid);
  const Rays rays(scene);
  const TransferCurve curve(shown.transfer_function);
  const Phong phong(scene, rays.view());
  const glm::dvec3 dims(scene.grid.dims);
  const glm::dmat3 to_world = against_gradient(scene.grid.direction, scene.grid.spacing * dims);
  const auto normal = [&](const glm::dvec3& p) {
    constexpr double h = 1e-5;
    return to_world * glm::dvec3(field(p.x + h, p.y, p.z) - field(p.x - h, p.y, p.z),
                                 field(p.x, p.y + h, p.z) - field(p.x, p.y - h, p.z),
                                 field(p.x, p.y, p.z + h) - field(p.x, p.y, p.z - h));
  };
  return along_rays(scene, pixels, [&](Pixel pixel) {
    const LatticeRay ray = rays.through(pixel);
    if (!(ray.enter < ray.leave)) return Rgba(0.0);
    const glm::dvec3 origin = (ray.origin + 0.5) / dims, step = ray.step / dims;
    const auto medium_at = [&](double s) {
      const glm::dvec3 p = origin + s * step;
      const auto sample = curve.at(scale * field(p.x, p.y, p.z));
      Medium medium{extinction(sample.opacity), sample.colour};
      if (scene.shaded() && sample.opacity > 0)
        medium.colour = phong.shade(medium.colour, normal(p), ray.to_viewer);
      return medium;
    };
    constexpr int pieces = 512;
    Piece seen;
    const double length = (ray.leave - ray.enter) / pieces;
    for (int i = 0; i < pieces && seen.transmittance >= 0.1 * tolerance; ++i) {
      const double a = ray.enter + i * length;
      seen = behind(seen, integrate(medium_at, a, a + length, tolerance / pieces / seen.transmittance));
    }
    return Rgba(seen.colour, 1 - seen.transmittance);
  });
}

double synth_scale(ScalarType type) {
  return visit_type(type, [](auto zero) {
    using T = decltype(zero);
    return std::is_integral_v<T> ? static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
  });
}

}  // namespace ringsplat::truth
