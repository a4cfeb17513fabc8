#include "classify/phong.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace ringsplat {
namespace {

/// Number of normals lit together.
constexpr std::size_t block = 64;

/// Clamps to the largest float, so that 0 times a scale stays 0.
constexpr float most = std::numeric_limits<float>::max();

struct Lighting {
  glm::vec3 light, viewer;  ///< unit directions
  float light_viewer;       ///< cosine between them
  float ambient, diffuse;
  float faint;  ///< up to this cosine the highlight is less than half a step of a 16-bit colour
};

/// Cosines between the mirrored light and the viewer; 0 where no highlight is seen.
using Mirrored = float[block];

/// Computes the scales of a block of normals; true when some highlights are not faint. A loop that compilers
/// vectorise: selections instead of branches.
bool light_block(const float* x, const float* y, const float* z, const Lighting& lighting, float* scales,
                 Mirrored& mirrored) {
  const glm::vec3 light = lighting.light, viewer = lighting.viewer;
  const float light_viewer = lighting.light_viewer, ambient = lighting.ambient, diffuse = lighting.diffuse,
              faint = lighting.faint;
  int bright = 0;
  for (std::size_t k = 0; k < block; ++k) {
    const float facing_light = x[k] * light.x + y[k] * light.y + z[k] * light.z,
                facing_viewer = x[k] * viewer.x + y[k] * viewer.y + z[k] * viewer.z;
    // A surface in a volume has no inside: n and −n are lit alike, and a highlight needs light and viewer on
    // the same side.
    const float same_side = facing_light * facing_viewer, lobe = same_side + same_side - light_viewer;
    mirrored[k] = same_side > 0 ? lobe : 0;
    bright |= int(mirrored[k] > faint);
    const float scale = ambient + diffuse * std::abs(facing_light);
    scales[k] = scale < most ? scale : most;
  }
  return bright != 0;
}

glm::dvec3 unit_direction(const glm::dvec3& v) {
  return glm::normalize(v / std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}));
}

float to_float(double v) { return static_cast<float>(std::min(v, double(most))); }

/// One code of each two opposite directions, and no_normal.
constexpr std::size_t half_codes = opposite_codes / 2 + 1;
/// Rounded up to whole blocks.
constexpr std::size_t table_size = (half_codes + block - 1) / block * block;

/// Decoded normals of these codes, made once: tables are made anew for every view.
struct Normals {
  std::vector<float> x, y, z;
};
const Normals& all_normals() {
  static const Normals normals = [] {
    Normals decoded;
    for (auto* axis : {&decoded.x, &decoded.y, &decoded.z}) axis->assign(table_size, 0.0F);
    for (std::size_t code = 1; code < half_codes; ++code) {
      const glm::vec3 n(decode_normal(NormalCode(code)));
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
  const glm::dvec3 light = unit_direction(to_light), viewer = unit_direction(to_viewer);
  const float specular = to_float(material.specular), exponent = to_float(material.exponent);
  const Lighting lighting{light,
                          viewer,
                          float(glm::dot(light, viewer)),
                          to_float(material.ambient),
                          to_float(material.diffuse),
                          exponent > 0 ? std::pow(1e-6F, 1.0F / exponent) : 0.0F};
  scales_.resize(table_size);
  highlights_.resize(table_size);
  const Normals& n = all_normals();
  for (std::size_t first = 0; first < table_size; first += block) {
    Mirrored mirrored;
    float* scales = &scales_[first];
    // Blocks without a highlight, which are most, need no powers.
    if (!light_block(&n.x[first], &n.y[first], &n.z[first], lighting, scales, mirrored)) continue;
    for (std::size_t k = 0; k < block; ++k) {
      if (!(mirrored[k] > lighting.faint)) continue;
      scales[k] = -scales[k];
      highlights_[first + k] = specular * std::pow(std::min(mirrored[k], 1.0F), exponent);
    }
  }
  scales_[no_normal] = 1;
  highlights_[no_normal] = 0;
}

}  // namespace ringsplat
