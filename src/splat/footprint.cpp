#include "splat/footprint.hpp"

#include <fmt/format.h>

#include <cmath>
#include <glm/matrix.hpp>
#include <numbers>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr double widest_half_extent =
    268435456;  // 2^28: windows then fit 32-bit pixel arithmetic with room to spare

/// The symmetric matrix with the eigenvalue `along` in `direction` and `across` perpendicular to it.
glm::dmat2 compose(double along, double across, glm::dvec2 direction) {
  const double xx = across + (along - across) * direction.x * direction.x;
  const double xy = (along - across) * direction.x * direction.y;
  const double yy = across + (along - across) * direction.y * direction.y;
  return {xx, xy, xy, yy};
}

}  // namespace

Footprint make_footprint(const ViewTransform& view, Axis axis, double radius) {
  if (!(radius >= 0.5 && radius <= 8))
    throw InputError(fmt::format("kernel radius {} is not within 0.5 to 8 voxels", radius),
                     "1.6 is a good radius: --radius 1.6");
  const auto [u, v] = in_plane(axis);
  // From steps along u and v to pixels.
  const glm::dmat2 block(glm::dvec2(view.linear[u]), glm::dvec2(view.linear[v]));
  glm::dmat2 variance = radius * radius * block * glm::transpose(block);
  const double trace = variance[0][0] + variance[1][1];
  if (!(trace <= widest_half_extent * widest_half_extent))
    throw InputError(fmt::format("one voxel's kernel would be {:.3g} pixels wide", 2 * std::sqrt(trace)),
                     "choose a smaller zoom or check the view's matrix");

  Footprint footprint;
  // The eigenvalues are centre ± spread.
  const double centre = 0.5 * (variance[0][0] + variance[1][1]),
               difference = 0.5 * (variance[0][0] - variance[1][1]),
               spread = std::hypot(difference, variance[0][1]);
  constexpr double floor = narrowest_half_width * narrowest_half_width;
  if (centre - spread >= floor) {
    footprint.p = glm::inverse(block) / radius;
  } else {
    const double large = std::max(centre + spread, floor),
                 angle = 0.5 * std::atan2(variance[0][1], difference);  // of its direction
    const glm::dvec2 direction{std::cos(angle), std::sin(angle)};
    variance = compose(large, floor, direction);
    footprint.p = compose(1 / std::sqrt(large), 1 / std::sqrt(floor), direction);
  }
  const glm::dmat2 form = glm::transpose(footprint.p) * footprint.p;
  footprint.d = -form[0][0];
  footprint.e = -2 * form[1][0];
  footprint.f = -form[1][1];
  footprint.half = {std::sqrt(variance[0][0]), std::sqrt(variance[1][1])};
  const double cell = std::abs(glm::determinant(block));
  footprint.weight = 3 * cell * std::abs(glm::determinant(footprint.p)) / std::numbers::pi;
  return footprint;
}

int pass_stride(double radius) { return std::max(1, static_cast<int>(std::ceil(2 * radius))); }

}  // namespace ringsplat
