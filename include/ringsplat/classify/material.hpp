#pragma once

namespace ringsplat {

/// Phong's reflection (Phong 1975), white light, two-sided.
struct PhongMaterial {
  double ambient = 0.25, diffuse = 0.75, specular = 0.25, exponent = 24.0;
  bool operator==(const PhongMaterial&) const = default;
};

}  // namespace ringsplat
