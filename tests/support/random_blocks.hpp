#pragma once
// Volumes cut into blocks at random, each in an array of its own with ghosts, gaps, and axes in any order and
// direction.
#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/strides.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat::test {

/// The same numbers from every standard library.
class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  int below(int end) { return int(engine_() % unsigned(end)); }

 private:
  std::mt19937 engine_;
};

/// Cuts the box into `count` blocks, or fewer where it has not so many voxels.
inline std::vector<VoxelBox> cut_up(const VoxelBox& box, int count, Dice& dice) {
  std::vector<VoxelBox> blocks{box};
  for (int tries = 0; int(blocks.size()) < count && tries < 20 * count; ++tries) {
    VoxelBox& low = blocks[std::size_t(dice.below(int(blocks.size())))];
    const int axis = dice.below(3), width = low.dims()[axis];
    if (width < 2) continue;
    VoxelBox high = low;
    high.first[axis] = low.end[axis] = low.first[axis] + 1 + dice.below(width - 1);
    blocks.push_back(high);
  }
  return blocks;
}

/// Planes, pencils or bricks of equal or unequal thickness: so many cuts along each axis.
inline std::vector<VoxelBox> lattice_of_blocks(const VoxelBox& box, const glm::ivec3& counts) {
  std::vector<VoxelBox> blocks;
  const auto face = [&](int axis, int k) {
    return box.first[axis] + int(std::int64_t(box.dims()[axis]) * k / counts[axis]);
  };
  for (int z = 0; z < counts.z; ++z)
    for (int y = 0; y < counts.y; ++y)
      for (int x = 0; x < counts.x; ++x) {
        const VoxelBox block{{face(0, x), face(1, y), face(2, z)},
                             {face(0, x + 1), face(1, y + 1), face(2, z + 1)}};
        if (glm::all(glm::greaterThan(block.dims(), glm::ivec3(0)))) blocks.push_back(block);
      }
  return blocks;
}

/// A block's voxels in an array of its own.
struct BlockArray {
  VoxelBox extent;
  std::vector<std::byte> memory;
  std::size_t first = 0;
  Strides strides;
  const std::byte* first_voxel() const { return memory.data() + first; }
};

/// Copies a block out of a whole volume. What lies between and around its voxels is rubbish.
inline BlockArray block_array(const Grid& grid, std::span<const std::byte> voxels, const VoxelBox& extent,
                              Dice& dice) {
  BlockArray block{extent, {}, 0, {}};
  const std::size_t scalar = size_of(grid.type);
  std::array<int, 3> order{0, 1, 2};
  for (int k = 2; k > 0; --k) std::swap(order[std::size_t(k)], order[std::size_t(dice.below(k + 1))]);
  std::array<std::int64_t, 3> stride{};
  std::int64_t step = std::int64_t(scalar) * (1 + dice.below(2));
  std::int64_t first = 0;
  for (const int axis : order) {
    const int ghosts = dice.below(3);
    const bool backwards = dice.below(2) == 1;
    const int width = extent.dims()[axis];
    stride[std::size_t(axis)] = backwards ? -step : step;
    first += step * (ghosts + (backwards ? width - 1 : 0));
    step *= width + ghosts + dice.below(2);
  }
  block.strides = {stride[0], stride[1], stride[2]};
  block.first = std::size_t(first);
  block.memory.assign(std::size_t(step) + std::size_t(first), std::byte{0x5a});
  for (int z = extent.first.z; z < extent.end.z; ++z)
    for (int y = extent.first.y; y < extent.end.y; ++y)
      for (int x = extent.first.x; x < extent.end.x; ++x) {
        const auto from =
            (std::size_t(z) * std::size_t(grid.dims.y) + std::size_t(y)) * std::size_t(grid.dims.x) +
            std::size_t(x);
        const glm::ivec3 at = glm::ivec3(x, y, z) - extent.first;
        const std::int64_t to = first + at.x * stride[0] + at.y * stride[1] + at.z * stride[2];
        std::memcpy(block.memory.data() + to, voxels.data() + from * scalar, scalar);
      }
  return block;
}

}  // namespace ringsplat::test
