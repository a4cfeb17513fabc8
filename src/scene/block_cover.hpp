#pragma once
#include <span>

#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat {

/// A block in its volume, with the process that has it.
struct PlacedBlock {
  VoxelBox extent;
  int process = 0, number = 0;  ///< its number on that process
};

/// Throws InputError that names a hole, or two blocks that overlap and where, unless the blocks cover every
/// voxel of the grid exactly once. Each block lies within the grid.
void check_cover(const Grid& grid, std::span<const PlacedBlock> blocks);

}  // namespace ringsplat
