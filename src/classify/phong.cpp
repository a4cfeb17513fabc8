#include "ringsplat/classify/phong.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "classify/normal_lattice.hpp"
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

constexpr float not_made = -1.0F;

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

PhongTable::PhongTable(const PhongMaterial& material, const glm::dvec3& to_light, const glm::dvec3& to_viewer)
    : material_(material),
      light_(unit_direction(to_light, "light")),
      viewer_(unit_direction(to_viewer, "viewer")),
      // Below this the highlight is less than half a step of a 16-bit colour; most powers need not be taken.
      faint_(material.exponent > 0 ? std::pow(1e-6, 1.0 / material.exponent) : 0.0),
      entries_(normal_codes, Entry{not_made, 0.0F}) {
  check(material);
  entries_[no_normal] = {1.0F, 0.0F};
  std::fill(entries_.begin() + lattice_codes + 1, entries_.end(), Entry{1.0F, 0.0F});
}

void PhongTable::make(NormalCode normal) const {
  const glm::dvec3& n = all_normals()[normal];
  const double facing_light = glm::dot(n, light_), facing_viewer = glm::dot(n, viewer_);
  // A surface in a volume has no inside: n and −n are lit alike, and a highlight needs light and viewer on
  // the same side.
  const double same_side = facing_light * facing_viewer,
               mirrored = 2.0 * same_side - glm::dot(light_, viewer_);
  Entry entry{entry_value(material_.ambient + material_.diffuse * std::abs(facing_light)), 0.0F};
  if (same_side > 0 && mirrored > faint_)
    entry.add = entry_value(material_.specular * std::pow(mirrored, material_.exponent));
  entries_[normal] = entry;
}

void PhongTable::make_all() {
  for (std::size_t code = 0; code < normal_codes; ++code) entry(NormalCode(code));
}

}  // namespace ringsplat
