#pragma once
#include <cmath>
#include <limits>

namespace ringsplat::truth {

/// Levels of an 8-bit picture. All differences are in units of one level.
constexpr double levels = 255;

/// a − b in levels. A value that is not finite is infinitely far from every other value.
inline double levels_apart(double a, double b) {
  if (std::isfinite(a) && std::isfinite(b)) return levels * (a - b);
  const bool same = a == b || (std::isnan(a) && std::isnan(b));
  return same ? 0.0 : std::numeric_limits<double>::infinity();
}

}  // namespace ringsplat::truth
