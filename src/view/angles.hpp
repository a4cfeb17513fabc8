#pragma once
#include <cmath>
#include <numbers>

namespace ringsplat {

struct SinCos {
  double sine, cosine;
};

/// Sine and cosine of a finite angle in degrees; multiples of 90 give exactly 0, 1 and -1, so that a view
/// along an axis has exact zeros in its matrix.
inline SinCos sin_cos_degrees(double degrees) {
  int quadrant = 0;
  const double rest = std::remquo(degrees, 90.0, &quadrant) * (std::numbers::pi / 180.0);
  const double s = std::sin(rest), c = std::cos(rest);
  switch (quadrant & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace ringsplat
