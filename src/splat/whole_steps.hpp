#pragma once
#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>
#include <optional>

#include "splat/stencil.hpp"

namespace ringsplat {

/// Largest whole-pixel step between voxels.
inline constexpr int largest_step = 4;

/// Floats of one tap's weights in AlignedSlice. They serve a pixel block that begins at any pixel of a step.
inline constexpr int tap_floats = 4 * (block_pixels + largest_step - 1);

/// Pixels from voxel to voxel, where u goes right, v goes down, and both steps are 1, 2 or 4; empty for all
/// other views. `to_pixels`: from lattice (u, v).
inline std::optional<glm::ivec2> whole_steps(const glm::dmat2& to_pixels) {
  const auto is_whole = [](double step) { return step == 1 || step == 2 || step == largest_step; };
  const glm::dvec2 u = to_pixels[0], v = to_pixels[1];
  if (u.y != 0 || v.x != 0 || !is_whole(u.x) || !is_whole(v.y)) return {};
  return glm::ivec2(int(u.x), int(v.y));
}

}  // namespace ringsplat
