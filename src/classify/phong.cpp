#include "classify/phong.hpp"

#include <cmath>
#include <glm/geometric.hpp>

namespace ringsplat {
namespace {

/// Clamps to the largest float, so that 0 times a scale stays 0.
constexpr float most = std::numeric_limits<float>::max();

glm::dvec3 unit_direction(const glm::dvec3& v) {
  return glm::normalize(v / std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}));
}

float to_float(double v) { return static_cast<float>(std::min(v, double(most))); }

/// One code of each two opposite directions, and no_normal.
constexpr std::size_t half_codes = opposite_codes / 2 + 1;

}  // namespace

PhongTable::PhongTable(const PhongMaterial& material, const glm::dvec3& to_light, const glm::dvec3& to_viewer)
    : scales_(half_codes, 1.0F), highlights_(half_codes, 0.0F) {
  const glm::dvec3 unit_light = unit_direction(to_light), unit_viewer = unit_direction(to_viewer);
  const glm::vec3 light(unit_light), viewer(unit_viewer);
  const auto light_viewer = float(glm::dot(unit_light, unit_viewer));
  const float ambient = to_float(material.ambient), diffuse = to_float(material.diffuse),
              specular = to_float(material.specular), exponent = to_float(material.exponent);
  // Up to this cosine the highlight is less than half a step of a 16-bit colour.
  const float faint = exponent > 0 ? std::pow(1e-6F, 1.0F / exponent) : 0.0F;
  for (std::size_t code = 1; code < half_codes; ++code) {
    const glm::vec3 n(decode_normal(NormalCode(code)));
    const float facing_light = n.x * light.x + n.y * light.y + n.z * light.z,
                facing_viewer = n.x * viewer.x + n.y * viewer.y + n.z * viewer.z;
    scales_[code] = std::min(ambient + diffuse * std::abs(facing_light), most);
    // A surface in a volume has no inside: n and −n are lit alike, and a highlight needs light and viewer on
    // the same side.
    const float same_side = facing_light * facing_viewer, mirrored = same_side + same_side - light_viewer;
    if (!(same_side > 0 && mirrored > faint)) continue;
    scales_[code] = -scales_[code];
    highlights_[code] = specular * std::pow(std::min(mirrored, 1.0F), exponent);
  }
}

}  // namespace ringsplat
