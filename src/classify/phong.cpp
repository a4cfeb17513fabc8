#include "ringsplat/classify/phong.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

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

/// Beyond the largest float there is no colour either: 0 times it must stay 0.
float entry_value(double v) { return float(std::min(v, double(std::numeric_limits<float>::max()))); }

/// Half of the codes, one of each two opposite directions, and no_normal.
constexpr std::size_t half_codes = opposite_codes / 2 + 1;

/// Their normals, decoded once: tables are made anew for every view.
struct Normals {
  std::vector<double> x, y, z;
};
const Normals& all_normals() {
  static const Normals normals = [] {
    Normals decoded;
    for (auto* axis : {&decoded.x, &decoded.y, &decoded.z}) axis->assign(half_codes, 0.0);
    for (std::size_t code = 1; code < half_codes; ++code) {
      const glm::dvec3 n = decode_normal(NormalCode(code));
      decoded.x[code] = n.x;
      decoded.y[code] = n.y;
      decoded.z[code] = n.z;
    }
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
  entries_.resize(half_codes);
  const Normals& n = all_normals();
  // In blocks: first what a compiler makes vectors of, then the few powers.
  constexpr std::size_t block = 64;
  for (std::size_t first = 0; first < half_codes; first += block) {
    const std::size_t count = std::min(block, half_codes - first);
    std::array<double, block> mirrored;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t code = first + k;
      const double facing_light = n.x[code] * light.x + n.y[code] * light.y + n.z[code] * light.z;
      const double facing_viewer = n.x[code] * viewer.x + n.y[code] * viewer.y + n.z[code] * viewer.z;
      // A surface in a volume has no inside: n and −n are lit alike, and a highlight needs light and
      // viewer on the same side.
      const double same_side = facing_light * facing_viewer, lobe = 2.0 * same_side - light_viewer;
      mirrored[k] = same_side > 0 ? lobe : 0.0;
      entries_[code] = {entry_value(material.ambient + material.diffuse * std::abs(facing_light)), 0.0F};
    }
    for (std::size_t k = 0; k < count; ++k)
      if (mirrored[k] > faint)
        entries_[first + k].add = entry_value(material.specular * std::pow(mirrored[k], material.exponent));
  }
  entries_[no_normal] = {1.0F, 0.0F};
}

}  // namespace ringsplat
