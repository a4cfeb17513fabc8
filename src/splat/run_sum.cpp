#include "splat/run_sum.hpp"

#include <bit>

namespace ringsplat {

DrawnBlocks RunSum::draw(const VoxelRuns& blocks, std::uint64_t most) {
  splats_.clear();
  const PackedVoxel* voxel = blocks.voxels;
  DrawnBlocks drawn;
  while (drawn.blocks < blocks.count && splats_.size() < most) {
    VoxelRun block;
    std::memcpy(&block, blocks.blocks + drawn.blocks * sizeof block, sizeof block);
    ++drawn.blocks;
    dda_.begin_row(slice_, int(block.row));
    for (std::uint64_t mask = block.mask; mask != 0; mask &= mask - 1) {
      const glm::dvec3 position = dda_.position(block.first + std::uint32_t(std::countr_zero(mask)));
      splats_.push_back(make_splat(footprint_, anchor(position.x, position.y), unpack(*voxel++)));
    }
  }
  drawn.counts = sum_.draw(splats_);
  return drawn;
}

}  // namespace ringsplat
