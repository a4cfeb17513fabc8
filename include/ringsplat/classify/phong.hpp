#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <vector>

#include "ringsplat/classify/classifier.hpp"
#include "ringsplat/classify/normals.hpp"
#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// Phong's reflection (Phong 1975), white light, two-sided.
struct PhongMaterial {
  double ambient = 0.25, diffuse = 0.75, specular = 0.25, exponent = 24.0;
  bool operator==(const PhongMaterial&) const = default;
};

/// Shading by lookup: one entry for each quantised normal and its opposite, which are lit alike, rebuilt when
/// the light or the view changes (Neumann 1992, section 3). Directions are in world space, towards the light
/// and towards the viewer.
class PhongTable {
 public:
  PhongTable(const PhongMaterial& material, const glm::dvec3& to_light, const glm::dvec3& to_viewer);

  /// The sample lit by its normal; colours are clamped to 1. no_normal leaves it as it is (unlit, not black).
  ClassifiedSample shade(NormalCode normal, const ClassifiedSample& s) const {
    return entries().light(s, place_of(normal));
  }

  /// A colour is multiplied by |scale|, and the highlight is added. Most normals have none, and the table is
  /// larger than a cache's share: so scales below zero, or −0, tell which have one, and others' are not read.
  struct Entries {
    const float *scales, *highlights;
    /// Where the highlight of a place is: there or, of those without one, at 0. A load of the sign's own does
    /// not wait for the scale to come out of a vector.
    std::size_t highlight_of(std::size_t place) const {
      std::int32_t sign;
      std::memcpy(&sign, scales + place, sizeof sign);
      return place & std::size_t(std::ptrdiff_t(sign >> 31));
    }
    ClassifiedSample light(const ClassifiedSample& s, std::size_t place) const {
      const float scale = std::abs(scales[place]), add = highlights[highlight_of(place)];
      return {std::min(s.r * scale + add, 1.0F), std::min(s.g * scale + add, 1.0F),
              std::min(s.b * scale + add, 1.0F), s.opacity};
    }
  };
  Entries entries() const { return {scales_.data(), highlights_.data()}; }
  /// Among the entries; numbers that are no code have no_normal's.
  static std::uint16_t place_of(NormalCode normal) {
    return std::uint16_t(std::max(std::min(int(normal), opposite_codes - int(normal)), 0));
  }

 private:
  std::vector<float> scales_, highlights_;  ///< by place; of place 0, no_normal's, 1 and 0
};

}  // namespace ringsplat
