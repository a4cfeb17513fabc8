#include "ringsplat/classify/phong.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

glm::dvec3 unit_direction(const glm::dvec3& v, const char* what) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
    throw InputError(fmt::format("the direction towards the {} is zero or not finite", what),
                     "give a world direction, for example 0 -1 0");
  return glm::normalize(v / largest);
}

void check(const PhongMaterial& m) {
  for (const double v : {m.ambient, m.diffuse, m.specular, m.exponent})
    if (!std::isfinite(v) || v < 0)
      throw InputError(fmt::format("Phong material {} {} {} {} is negative or not finite", m.ambient,
                                   m.diffuse, m.specular, m.exponent),
                       "give ambient, diffuse, specular and exponent from 0 up");
}

/// Every code's normal, decoded once: tables are made anew for every view.
const std::vector<glm::dvec3>& all_normals() {
  static const std::vector<glm::dvec3> normals = [] {
    std::vector<glm::dvec3> decoded(normal_codes, glm::dvec3(0.0));
    for (std::size_t code = 1; code < normal_codes; ++code) decoded[code] = decode_normal(NormalCode(code));
    return decoded;
  }();
  return normals;
}

}  // namespace

PhongTable::PhongTable(const PhongMaterial& material, const glm::dvec3& to_light,
                       const glm::dvec3& to_viewer) {
  check(material);
  const glm::dvec3 light = unit_direction(to_light, "light"), viewer = unit_direction(to_viewer, "viewer");
  const double light_viewer = glm::dot(light, viewer);
  // Below this the highlight is less than half a step of a 16-bit colour; most powers need not be taken.
  const double faint = material.exponent > 0 ? std::pow(1e-6, 1.0 / material.exponent) : 0.0;
  entries_.assign(normal_codes, {1.0F, 0.0F});
  for (std::size_t code = 1; code < normal_codes; ++code) {
    const glm::dvec3& n = all_normals()[code];
    if (n == glm::dvec3(0.0)) continue;
    const double facing_light = glm::dot(n, light), facing_viewer = glm::dot(n, viewer);
    // A surface in a volume has no inside: n and −n are lit alike, and a highlight needs light and
    // viewer on the same side.
    const double same_side = facing_light * facing_viewer;
    const double mirrored = same_side > 0 ? 2.0 * same_side - light_viewer : 0.0;
    const double highlight = mirrored > faint ? std::pow(mirrored, material.exponent) : 0.0;
    entries_[code] = {float(material.ambient + material.diffuse * std::abs(facing_light)),
                      float(material.specular * highlight)};
  }
}

}  // namespace ringsplat
