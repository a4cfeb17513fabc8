#pragma once
#include <cstdint>

#include "ringsplat/splat/aligned_slice.hpp"
#include "ringsplat/splat/voxel_run.hpp"

namespace ringsplat {

/// Writes voxels' premultiplied RGBA in float32 to a row of pixels: the i-th bit of `mask`, which is not 0,
/// is a voxel at pixels x + i · step_x … x + (i + 1) · step_x − 1 of the row. Its colour and its opacity,
/// times opacity_weight, are what RegionPainter::draw adds for a splat. A voxel whose opacity is no number
/// that a footprint can give becomes 0. The same bits at every vector width.
void place_voxels(const AlignedSlice& slice, std::uint64_t mask, const FloatVoxel* voxels, int x, float* row);
void place_voxels(const AlignedSlice& slice, std::uint64_t mask, const HalfVoxel* voxels, int x, float* row);
void place_voxels(const AlignedSlice& slice, std::uint64_t mask, const ByteVoxel* voxels, int x, float* row);

}  // namespace ringsplat
