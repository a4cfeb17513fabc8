#pragma once
#include <cstddef>

#include "ringsplat/splat/aligned_slice.hpp"
#include "ringsplat/splat/voxel_run.hpp"

namespace ringsplat {

/// Writes `count` > 0 voxels' premultiplied RGBA in float32, each step_x times, to count · step_x pixels: the colour and the
/// opacity, times opacity_weight, that RegionPainter::draw adds for a splat. A voxel whose opacity is no number that a
/// footprint can give becomes 0. The same bits at every vector width.
void place_voxels(const AlignedSlice& slice, const FloatVoxel* voxels, std::size_t count, float* pixels);
void place_voxels(const AlignedSlice& slice, const HalfVoxel* voxels, std::size_t count, float* pixels);
void place_voxels(const AlignedSlice& slice, const ByteVoxel* voxels, std::size_t count, float* pixels);

}  // namespace ringsplat
