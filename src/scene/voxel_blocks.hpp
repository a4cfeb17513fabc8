#pragma once
#include <map>
#include <span>
#include <vector>

#include "ringsplat/volume/strides.hpp"
#include "ringsplat/volume/voxel_box.hpp"
#include "scene/scene.hpp"

namespace ringsplat {

/// A part of a volume in memory.
struct VoxelBlock {
  VoxelBox extent;
  const std::byte* first_voxel = nullptr;  ///< that of extent.first
  Strides strides;
};

/// Throws InputError on all processes when a process's blocks are wrong in themselves (not within the grid, a
/// null pointer), or all blocks together do not cover the grid once. Collective.
void check_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, Collectives& collectives);

/// Copies the voxels of all processes' blocks into the z slices of the GPs that own them. Blocks cover the
/// grid once. In rounds of one process to another, or to several: a process sends and receives at most
/// `round_bytes`, or one row of voxels, at a time. Collective.
void deal_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, std::map<int, SliceStore>& stores,
                 std::size_t round_bytes, const Sharing& sharing);

/// A block in its volume, with the process that has it.
struct PlacedBlock {
  VoxelBox extent;
  int process = 0, number = 0;  ///< its number on that process
};

/// Throws InputError that names a hole, or two blocks that overlap and where, unless the blocks cover every
/// voxel of the grid exactly once. Each block lies within the grid.
void check_cover(const Grid& grid, std::span<const PlacedBlock> blocks);

}  // namespace ringsplat
