#pragma once
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec2.hpp>

#include "frame/work_dealing.hpp"
#include "net/message.hpp"
#include "simulate/machine.hpp"
#include "splat/footprint.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {

/// A Renderer's software for a payload and its accept on a described machine.
inline double payload_message_seconds(const Machine& m) {
  return sending_seconds(m, sizeof(Header)) + m.message.receive;
}

/// What work costs on a described machine, when each voxel stands for `voxel_weight` of its slice and slices
/// travel in bundles of `bundle`.
inline WorkCosts splat_costs(const Machine& m, double voxel_weight, int bundle = 1) {
  return {.voxel = voxel_weight * drawing_seconds(m, 1, 0, 0, 0),
          .pixel = drawing_seconds(m, 0, 0, 1, 0),
          .payload = drawing_seconds(m, 0, 0, 0) + payload_message_seconds(m) / bundle,
          .visible = voxel_weight * encoding_seconds(m, 1, 1, 0),
          .hollow = voxel_weight * encoding_seconds(m, 1, 0, 0)};
}
inline WorkCosts sheet_costs(const Machine& m, double voxel_weight, int bundle = 1) {
  constexpr double side = CellRanges::side;
  const double voxel = voxel_weight / (side * side);
  return {.voxel = voxel * placing_seconds(m, 0, 1, 0),
          .pixel = painting_seconds(m, 1),
          .payload = placing_seconds(m, 0, 0) + payload_message_seconds(m) / bundle,
          .visible = voxel * selecting_seconds(m, 1, 1, 0),
          .hollow = voxel * selecting_seconds(m, 1, 0, 0),
          .block = side / std::sqrt(voxel_weight)};
}

/// Half extents, in pixels, of the kernels of voxels that are `voxel_weight` times as many in a slice.
inline glm::dvec2 narrowed(const glm::dvec2& half, double voxel_weight) {
  return glm::min(half, glm::max(half / std::sqrt(voxel_weight), glm::dvec2(narrowest_half_width)));
}

}  // namespace ringsplat
