#pragma once
#include <memory>

#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat {

/// The voxels of the finest level, of `finest` along the axes, that are shown by those of a level each of
/// whose voxels is as large as `each` of them.
VoxelBox box_in_finest(const VoxelBox& box, const glm::dvec3& each, const glm::ivec3& finest);

/// Copies what lies in the box of a z slice of `grid`: of every `step`-th row every `step`-th scalar.
void copy_clipped(const Grid& grid, const VoxelBox& box, const std::byte* slice, std::byte* out,
                  int step = 1);

/// Reads the volume cropped to a box from `full`, which must outlive it. Throws InputError when the box does
/// not lie within the volume.
std::unique_ptr<VolumeSource> clipped_source(VolumeSource& full, const VoxelBox& box);
/// Of a volume that it owns.
std::unique_ptr<VolumeSource> clipped_source(std::unique_ptr<VolumeSource> full, const VoxelBox& box);

/// Reads every `step`-th voxel along each axis, as a volume of this lattice.
std::unique_ptr<VolumeSource> skipping_source(std::unique_ptr<VolumeSource> full, const Grid& reduced,
                                              int step);

}  // namespace ringsplat
