#pragma once
#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>
#include <optional>

#include "splat/stencil.hpp"

namespace ringsplat {

/// The most pixels a voxel that count as whole steps.
inline constexpr int most_whole_steps = 4;

/// Floats of a tap's weights in AlignedSlice: of a block that begins at any pixel of a step.
inline constexpr int tap_floats = 4 * (block_pixels + most_whole_steps - 1);

/// Pixels from voxel to voxel along u, which is right, and v, which is down, where both are 1, 2 or 4; empty
/// elsewhere. `block` takes lattice (u, v) to pixels.
inline std::optional<glm::ivec2> whole_steps(const glm::dmat2& block) {
  const auto is_whole = [](double step) { return step == 1 || step == 2 || step == most_whole_steps; };
  if (block[0].y != 0 || block[1].x != 0 || !is_whole(block[0].x) || !is_whole(block[1].y)) return {};
  return glm::ivec2(int(block[0].x), int(block[1].y));
}

}  // namespace ringsplat
