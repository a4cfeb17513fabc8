#pragma once
#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "truth/scene.hpp"

namespace ringsplat::truth {

/// What a cell's eight corners have (number 4z + 2y + x), and interpolation between them.
template <class T>
using Corners = std::array<T, 8>;

template <class T>
T trilinear(const Corners<T>& c, const glm::dvec3& f) {
  const auto mix = [](const T& a, const T& b, double t) { return (1 - t) * a + t * b; };
  const T front = mix(mix(c[0], c[1], f.x), mix(c[2], c[3], f.x), f.y);
  const T back = mix(mix(c[4], c[5], f.x), mix(c[6], c[7], f.x), f.y);
  return mix(front, back, f.z);
}

/// The voxels to interpolate between; the same voxel twice where the field does not change along an axis.
struct Cell {
  glm::ivec3 low, high;
  glm::ivec3 corner(int c) const {
    return {(c & 1) ? high.x : low.x, (c & 2) ? high.y : low.y, (c & 4) ? high.z : low.z};
  }
};

/// The voxel nearest to a place. Of two that are equally near it is the one with the greater number, however
/// the place is rounded: rays often run along voxels' faces.
inline glm::ivec3 nearest_voxel(const glm::dvec3& place, const glm::ivec3& dims) {
  constexpr double rounding = 1e-9;
  return glm::clamp(glm::ivec3(glm::floor(place + (0.5 + rounding))), glm::ivec3(0), dims - 1);
}

struct CellValues {
  Corners<double> corners;
  double low, high;
  /// Never outside [low, high], whatever the rounding.
  double at(const glm::dvec3& f) const { return std::clamp(trilinear(corners, f), low, high); }
};

/// Nothing when a corner is not a number. Infinities become numbers beyond the transfer function's ends.
inline std::optional<CellValues> cell_values(const Scene& scene, const TransferCurve& curve,
                                             const Cell& cell) {
  CellValues values{{}, 1 / 0.0, -1 / 0.0};
  for (int c = 0; c < 8; ++c) {
    const double v = curve.bounded(scene.values[scene.index(cell.corner(c))]);
    if (std::isnan(v)) return std::nullopt;
    values.corners[std::size_t(c)] = v;
    values.low = std::min(values.low, v);
    values.high = std::max(values.high, v);
  }
  return values;
}

inline Corners<glm::dvec3> cell_normals(const Gradients& gradients, const Cell& cell) {
  Corners<glm::dvec3> normals;
  for (int c = 0; c < 8; ++c) normals[std::size_t(c)] = gradients.at(cell.corner(c));
  return normals;
}

}  // namespace ringsplat::truth
