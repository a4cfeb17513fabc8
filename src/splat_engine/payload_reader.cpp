#include "splat_engine/payload_reader.hpp"

namespace ringsplat {
namespace {

/// Voxels of aligned slices are summed as they lie in their rows, others splat by splat.
std::variant<RunSum, VoxelSum> sum_for(const SplatFrame& frame) {
  using Sum = std::variant<RunSum, VoxelSum>;
  const FrameGeometry& g = frame.geometry;
  const Axis axis = g.traversal.axis;
  const PixelRect largest = g.regions.rect(0);
  if (const auto aligned = AlignedFrame::of(frame.footprint, g.view, axis))
    return Sum(std::in_place_type<VoxelSum>, *aligned, largest);
  return Sum(std::in_place_type<RunSum>, frame.footprint, SliceDda(g.view, axis, g.grid.slice_width(axis)),
             largest);
}

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

PayloadReader::PayloadReader(const SplatFrame& frame) : geometry_(frame.geometry), sum_(sum_for(frame)) {}

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
  const auto [blocks, counts] = std::visit([&](auto& sum) { return sum.draw(left_, most); }, sum_);
  left_.blocks += blocks * sizeof(VoxelRun);
  left_.count -= blocks;
  left_.voxels += counts.drawn + counts.clipped + counts.hidden;
  return counts;
}

}  // namespace ringsplat
