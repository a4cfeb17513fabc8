#include "truth/shading.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace ringsplat::truth {

Phong::Phong(const Scene& scene, const ViewTransform& view)
    : material_(scene.frame.shown.material),
      to_light_(glm::normalize(view.right * scene.frame.shown.light.x + view.up * scene.frame.shown.light.y +
                               view.to_viewer * scene.frame.shown.light.z)) {}

Phong::Light Phong::light(const glm::dvec3& normal, const glm::dvec3& to_viewer) const {
  const double length = glm::length(normal);
  if (!(length > 0) || !std::isfinite(length)) return {};
  glm::dvec3 n = normal / length;
  if (glm::dot(n, to_viewer) < 0) n = -n;  // the side that is seen
  const double towards_light = glm::dot(n, to_light_);
  Light light{material_.ambient + material_.diffuse * std::abs(towards_light), 0};
  if (towards_light > 0) {
    const glm::dvec3 mirrored = 2 * towards_light * n - to_light_;
    const double toward_eye = glm::dot(mirrored, to_viewer);
    if (toward_eye > 0 && glm::dot(n, to_viewer) > 0)
      light.highlight = material_.specular * std::pow(toward_eye, material_.exponent);
  }
  return light;
}

glm::dmat3 against_gradient(const glm::dmat3& direction, const glm::dvec3& size) {
  const double smallest = std::min({size.x, size.y, size.z});
  const glm::dmat3 inverse = glm::inverse(direction);
  glm::dmat3 against{1.0};
  // The gradient is a covector, so it is mapped by the inverse transpose, whose columns are the inverse's
  // rows.
  for (int k = 0; k < 3; ++k)
    against[k] = -(smallest / size[k]) * glm::dvec3(inverse[0][k], inverse[1][k], inverse[2][k]);
  return against;
}

Gradients::Gradients(const Scene& scene)
    : scene_(scene), to_world_(against_gradient(scene.grid.direction, scene.grid.spacing)) {
  double largest = 0;
  for (const double v : scene.values)
    if (std::isfinite(v)) largest = std::max(largest, std::abs(v));
  if (largest > 0) scale_ = 1 / static_cast<long double>(largest);
}

glm::dvec3 Gradients::at(const glm::ivec3& voxel) const {
  const auto& dims = scene_.grid.dims;
  const std::size_t stride[3] = {1, std::size_t(dims.x), std::size_t(dims.x) * std::size_t(dims.y)};
  const std::size_t here = scene_.index(voxel);
  const double centre = scene_.values[here];
  if (!std::isfinite(centre)) return glm::dvec3(0.0);
  glm::dvec3 difference{0.0};
  for (int k = 0; k < 3; ++k) {
    double before = centre, after = centre;
    int steps = 0;
    if (voxel[k] > 0 && std::isfinite(scene_.values[here - stride[k]]))
      before = scene_.values[here - stride[k]], ++steps;
    if (voxel[k] + 1 < dims[k] && std::isfinite(scene_.values[here + stride[k]]))
      after = scene_.values[here + stride[k]], ++steps;
    if (steps > 0)
      difference[k] = static_cast<double>(
          (static_cast<long double>(after) - static_cast<long double>(before)) * scale_ / steps);
  }
  return to_world_ * difference;
}

}  // namespace ringsplat::truth
