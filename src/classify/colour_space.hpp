#pragma once
#include <glm/vec3.hpp>
#include <optional>
#include <string>

namespace ringsplat {

/// Spaces in which ParaView interpolates colours.
enum class ColourSpace { rgb, hsv, hsv_wrapped, lab, diverging };

/// "RGB", "HSV", "Lab" or "CIELAB", "Diverging"; nothing for any other name.
std::optional<ColourSpace> colour_space_from(const std::string& name, bool hsv_wrap);

/// The display colour at `t` in [0, 1] on the way from `a` to `b` (display colours) in the space; 0..1.
glm::dvec3 interpolate(ColourSpace space, const glm::dvec3& a, const glm::dvec3& b, double t);

}  // namespace ringsplat
