#pragma once
#include <memory>

#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat {

/// Copies the rows of a z slice of `grid` that lie in the box: box.dims().x * box.dims().y scalars.
void copy_clipped(const Grid& grid, const VoxelBox& box, const std::byte* slice, std::byte* out);

/// Reads the volume cropped to a box from `full`, which must outlive it. Throws InputError when the box does
/// not lie within the volume.
std::unique_ptr<VolumeSource> clipped_source(VolumeSource& full, const VoxelBox& box);
/// Of a volume that it owns.
std::unique_ptr<VolumeSource> clipped_source(std::unique_ptr<VolumeSource> full, const VoxelBox& box);

}  // namespace ringsplat
