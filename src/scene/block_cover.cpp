#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "scene/scene.hpp"
#include "scene/voxel_blocks.hpp"

namespace ringsplat {

std::string text_of(const VoxelBox& box) {
  return fmt::format("{}:{},{}:{},{}:{}", box.first.x, box.end.x, box.first.y, box.end.y, box.first.z,
                     box.end.z);
}

namespace {

using Blocks = std::vector<const PlacedBlock*>;

std::string text_of(const PlacedBlock& block) {
  return fmt::format("block {} of rank {} ({})", block.number, block.process, text_of(block.extent));
}

bool covers(const VoxelBox& outer, const VoxelBox& inner) {
  return glm::all(glm::lessThanEqual(outer.first, inner.first)) &&
         glm::all(glm::greaterThanEqual(outer.end, inner.end));
}

bool meet(const VoxelBox& a, const VoxelBox& b) {
  return glm::all(glm::lessThan(a.first, b.end)) && glm::all(glm::lessThan(b.first, a.end));
}

struct Cut {
  int axis = -1, at = 0;
};

/// A face of a block within the box, near the middle of all such faces of the axis that has most; there is
/// one unless every block covers the box.
Cut cut_of(const VoxelBox& box, const Blocks& blocks) {
  Cut cut;
  std::size_t most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<int> faces;
    for (const PlacedBlock* block : blocks)
      for (const int face : {block->extent.first[axis], block->extent.end[axis]})
        if (box.first[axis] < face && face < box.end[axis]) faces.push_back(face);
    if (faces.size() <= most) continue;
    most = faces.size();
    const auto middle = faces.begin() + std::ptrdiff_t(most / 2);
    std::nth_element(faces.begin(), middle, faces.end());
    cut = {axis, *middle};
  }
  return cut;
}

/// `blocks`: those that meet the box.
void check_part(const VoxelBox& box, const Blocks& blocks) {
  if (blocks.empty())
    throw InputError(fmt::format("no block covers voxels {}", text_of(box)),
                     "all blocks together must cover the grid, ghosts left out");
  const auto whole = [&](const PlacedBlock* block) { return covers(block->extent, box); };
  const auto first = std::find_if(blocks.begin(), blocks.end(), whole);
  if (first != blocks.end() && blocks.size() == 1) return;
  if (first != blocks.end()) {
    const PlacedBlock& other =
        **std::find_if(blocks.begin(), blocks.end(), [&](auto* b) { return b != *first; });
    throw InputError(fmt::format("{} and {} overlap", text_of(**first), text_of(other)),
                     "every voxel belongs to one block; leave out ghosts");
  }
  const Cut cut = cut_of(box, blocks);
  VoxelBox low = box, high = box;
  low.end[cut.axis] = high.first[cut.axis] = cut.at;
  for (const VoxelBox& part : {low, high}) {
    Blocks meeting;
    std::copy_if(blocks.begin(), blocks.end(), std::back_inserter(meeting),
                 [&](const PlacedBlock* block) { return meet(block->extent, part); });
    check_part(part, meeting);
  }
}

}  // namespace

void check_cover(const Grid& grid, std::span<const PlacedBlock> blocks) {
  Blocks all;
  for (const PlacedBlock& block : blocks) all.push_back(&block);
  check_part(whole_box(grid), all);
}

}  // namespace ringsplat
