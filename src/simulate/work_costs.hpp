#pragma once
#include <glm/vec2.hpp>

#include "frame/work_dealing.hpp"
#include "simulate/machine.hpp"

namespace ringsplat {

/// What work costs on a described machine, when each voxel stands for `voxel_weight` of its slice and slices
/// travel in bundles of `bundle`.
WorkCosts splat_costs(const Machine& machine, double voxel_weight, int bundle = 1);
WorkCosts sheet_costs(const Machine& machine, double voxel_weight, int bundle = 1);

/// A Renderer's software for a payload and its accept on a described machine.
double payload_message_seconds(const Machine& machine);

/// Half extents, in pixels, of the kernels of voxels that are `voxel_weight` times as many in a slice.
glm::dvec2 narrowed(const glm::dvec2& half, double voxel_weight);

}  // namespace ringsplat
