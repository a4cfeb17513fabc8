#pragma once
#include <algorithm>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <numbers>

namespace ringsplat {

inline bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool is_finite(const glm::dmat3& m) { return is_finite(m[0]) && is_finite(m[1]) && is_finite(m[2]); }

inline double largest_magnitude(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Euclidean length; squares neither overflow nor vanish.
inline double safe_length(const glm::dvec3& v) {
  const double scale = largest_magnitude(v);
  return scale > 0.0 ? scale * glm::length(v / scale) : 0.0;
}

/// Unit vector along `v`, which is not zero. One that lies along an axis comes out exactly.
inline glm::dvec3 unit(const glm::dvec3& v) {
  const glm::dvec3 scaled = v / largest_magnitude(v);
  return scaled / glm::length(scaled);
}

/// Volume spanned by the columns' directions: 1 when orthogonal, 0 when they lie in a plane, whatever their
/// lengths. Zero for a column of zeros.
inline double spanned_volume(const glm::dmat3& m) {
  for (int k = 0; k < 3; ++k)
    if (!(largest_magnitude(m[k]) > 0.0)) return 0.0;
  return std::abs(glm::determinant(glm::dmat3(unit(m[0]), unit(m[1]), unit(m[2]))));
}

/// Three vectors whose directions span less than this do not count as independent.
inline constexpr double least_volume = 1e-12;

struct SinCos {
  double sine, cosine;
};

/// Sine and cosine of a finite angle in degrees; multiples of 90 give exactly 0, 1 and -1, so that a view
/// along an axis has exact zeros in its matrix.
inline SinCos sin_cos_degrees(double degrees) {
  int quadrant = 0;
  const double rest = std::remquo(degrees, 90.0, &quadrant) * (std::numbers::pi / 180.0);
  SinCos turned{std::sin(rest), std::cos(rest)};
  for (int turns = quadrant & 3; turns > 0; --turns) turned = {turned.cosine, -turned.sine};
  return turned;
}

}  // namespace ringsplat
