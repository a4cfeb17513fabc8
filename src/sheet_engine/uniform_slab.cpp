#include "sheet_engine/uniform_slab.hpp"

#include <algorithm>
#include <cmath>

#include "sheet_engine/fill_slab_table.hpp"

namespace ringsplat {

double extinction(double opacity) {
  constexpr double most = 1e4;
  return opacity < 1 ? std::min(-std::log1p(-opacity), most) : most;
}

std::uint64_t uniform_slab(double extinction, const glm::dvec3& colour, double length) {
  const double x = extinction * length, opacity = -std::expm1(-x);
  if (!(opacity > 0)) return 0;
  double centroid = 0.5, spread = std::sqrt(1.0 / 12);
  if (x > 1e-3) {
    const double left = std::exp(-x) / opacity;
    centroid = 1 / x - left;
    const double square = 2 / (x * x) - left * (1 + 2 / x);
    spread = std::sqrt(std::max(0.0, square - centroid * centroid));
  }
  return packed({opacity, colour.r, colour.g, colour.b, centroid, spread});
}

}  // namespace ringsplat
