#pragma once
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "images/drawing.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat::serve {

/// Places of the lattice that are joined, of which pictures tell how far they lie from each other.
using Ruler = std::vector<glm::dvec3>;

/// How a picture of what is shown has it, in light or dark as the background's sRGB asks for. `unit`: of the
/// spacing; empty: unknown. Throws InputError when there is no font.
Overlay ruler_overlay(const Ruler& ruler, const Shown& shown, const Grid& grid, const std::string& unit,
                      const glm::dvec3& background);

}  // namespace ringsplat::serve
