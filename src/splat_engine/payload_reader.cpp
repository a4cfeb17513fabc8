#include "splat_engine/payload_reader.hpp"

namespace ringsplat {
namespace {

/// Reads a region's part and moves `at` behind it; false when the part is not whole or has voxels outside of
/// a slice of width × height voxels.
bool take_part(std::span<const std::byte> body, std::size_t& at, std::uint32_t width, std::uint32_t height,
               PayloadPart& part) {
  BlockGroup group;
  if (!take(body, at, group) || group.blocks == 0 || (body.size() - at) / sizeof(VoxelRun) < group.blocks)
    return false;
  const std::byte* const blocks = body.data() + at;
  std::uint64_t voxels = 0;
  for (std::uint32_t k = 0; k < group.blocks; ++k) {
    VoxelRun block;
    if (!take(body, at, block) || block.row >= height || block.first >= width || block.first % 64 != 0 ||
        block.mask == 0)
      return false;
    const std::uint32_t columns = width - block.first;
    if (columns < 64 && block.mask >> columns != 0) return false;
    voxels += std::uint64_t(std::popcount(block.mask));
  }
  if (voxels != group.voxels || (body.size() - at) / sizeof(PackedVoxel) < group.voxels) return false;
  part = {group.region,
          group.voxels,
          {blocks, group.blocks, reinterpret_cast<const PackedVoxel*>(body.data() + at)}};
  at += group.voxels * sizeof(PackedVoxel);
  return true;
}

}  // namespace

PayloadReader::PayloadReader(const SplatFrame& frame)
    : geometry_(frame.geometry),
      sum_(frame.footprint,
           SliceDda(geometry_.view, geometry_.traversal.axis,
                    geometry_.grid.slice_width(geometry_.traversal.axis)),
           geometry_.regions.rect(0)) {}

std::vector<PayloadPart> PayloadReader::parts(std::span<const std::byte> body,
                                              const std::function<bool(int)>& owned) const {
  const auto width = std::uint32_t(geometry_.grid.slice_width(geometry_.traversal.axis)),
             height = std::uint32_t(geometry_.grid.slice_height(geometry_.traversal.axis));
  std::vector<PayloadPart> parts;
  for (std::size_t at = 0; at < body.size();) {
    const int last = parts.empty() ? -1 : parts.back().region;
    PayloadPart part;
    if (!take_part(body, at, width, height, part) || part.region <= last || !owned(part.region))
      throw OtherBuild(fmt::format("a payload of {} bytes is not understood at byte {}", body.size(), at));
    parts.push_back(part);
  }
  return parts;
}

DrawCounts PayloadReader::draw(std::uint32_t most) {
  const auto [blocks, counts] = sum_.draw(left_, most);
  left_.blocks += blocks * sizeof(VoxelRun);
  left_.count -= blocks;
  left_.voxels += counts.drawn + counts.clipped + counts.hidden;
  return counts;
}

}  // namespace ringsplat
