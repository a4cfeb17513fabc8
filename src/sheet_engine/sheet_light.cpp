#include "sheet_engine/sheet_light.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace ringsplat {

namespace {

/// Orthonormal coordinates of the world in which gradients are an upper triangle times differences along u, v
/// and the traversed axis, in front to back order.
struct GradientAxes {
  glm::dvec3 basis[3];
  double upper[3][3] = {};
};

GradientAxes gradient_axes(const FrameGeometry& g) {
  const Grid& grid = g.grid;
  const glm::dmat3 inverse = glm::inverse(grid.direction);
  const double smallest = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  const auto [u, v] = in_plane(g.traversal.axis);
  const int axes[] = {u, v, static_cast<int>(g.traversal.axis)};
  // A gradient is a covector: it is mapped to the world by the inverse transpose. Surfaces face away from
  // higher values.
  glm::dvec3 world[3];
  for (int i = 0; i < 3; ++i) {
    const int k = axes[i];
    world[i] = -(smallest / grid.spacing[k]) * glm::dvec3(inverse[0][k], inverse[1][k], inverse[2][k]);
  }
  if (!g.traversal.ascending) world[2] = -world[2];

  // Gram and Schmidt: world = basis · upper triangle.
  GradientAxes to;
  for (int i = 0; i < 3; ++i) {
    glm::dvec3 rest = world[i];
    for (int k = 0; k < i; ++k) {
      to.upper[k][i] = glm::dot(to.basis[k], world[i]);
      rest -= to.upper[k][i] * to.basis[k];
    }
    to.upper[i][i] = glm::length(rest);
    to.basis[i] = rest / to.upper[i][i];
  }
  return to;
}

}  // namespace

GradientLight gradient_light(const SheetFrame& frame, double most) {
  const FrameGeometry& g = frame.geometry;
  const auto [basis, upper] = gradient_axes(g);
  const ViewTransform& view = g.view;
  const Shown& shown = frame.shown;
  const glm::dvec3 to_light =
      glm::normalize(view.right * shown.light.x + view.up * shown.light.y + view.to_viewer * shown.light.z);
  const double scale = most > 0 ? 1 / most : 1;
  const auto scaled = [scale](double x) { return static_cast<float>(x * scale); };
  GradientLight light;
  light.uu = scaled(upper[0][0]);
  light.uv = scaled(upper[0][1]);
  light.uk = scaled(upper[0][2]);
  light.vv = scaled(upper[1][1]);
  light.vk = scaled(upper[1][2]);
  light.kk = scaled(upper[2][2]);
  const auto mixed = [&](int i, int k) { return std::abs(upper[i][k]) > 1e-12 * upper[k][k]; };
  light.oblique = mixed(0, 1) || mixed(0, 2) || mixed(1, 2);
  for (int i = 0; i < 3; ++i) {
    light.light[i] = static_cast<float>(glm::dot(basis[i], to_light));
    light.viewer[i] = static_cast<float>(glm::dot(basis[i], view.to_viewer));
  }
  light.between = static_cast<float>(glm::dot(to_light, view.to_viewer));
  light.ambient = static_cast<float>(shown.material.ambient);
  light.diffuse = static_cast<float>(shown.material.diffuse);
  light.specular = static_cast<float>(shown.material.specular);
  light.exponent = static_cast<float>(shown.material.exponent);
  return light;
}

void set_lengths(const SheetFrame& frame, EyeGrid& eye) {
  const FrameGeometry& g = frame.geometry;
  const Grid& grid = g.grid;
  const GradientAxes axes = gradient_axes(g);
  const auto [u, v] = in_plane(g.traversal.axis);
  const int lattice[] = {u, v, static_cast<int>(g.traversal.axis)};
  const double unit = frame.unit_length();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      eye.axes[i][k] = static_cast<float>(
          glm::dot(axes.basis[i], grid.direction[lattice[k]] * (grid.spacing[lattice[k]] / unit)));
  eye.table_length = frame.by_length() ? static_cast<float>(frame.step_length()) : 0;
}

}  // namespace ringsplat
