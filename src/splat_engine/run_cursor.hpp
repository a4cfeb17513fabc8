#pragma once
#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "base/byte_stream.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "splat/voxel_run.hpp"
#include "splat_engine/payload_reader.hpp"

namespace ringsplat {

/// Splits a payload of runs into parts, and steps through a part block by block or run by run.
template <class Voxel>
class RunCursor {
 public:
  /// `width`, `height`: the slice's size in voxels.
  RunCursor(int width, int height) : width_(std::uint32_t(width)), height_(std::uint32_t(height)) {}

  /// Throws RunError unless `body` is a payload of runs in such a slice, for regions in ascending order whose
  /// `owned` is true.
  std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                 const std::function<bool(int)>& owned) const {
    std::vector<PayloadPart> parts;
    for (std::size_t at = 0, begin = 0; at < body.size(); begin = at) {
      BlockGroup group;
      const int last = parts.empty() ? -1 : parts.back().region;
      if (!take(body, at, group) || group.region <= last || !owned(group.region) ||
          !check_blocks(group, body, at))
        throw RunError(fmt::format("a payload of {} bytes is not understood at byte {}", body.size(), at),
                       "all ranks must run the same build");
      parts.push_back({group.region, body.subspan(begin, at - begin)});
    }
    return parts;
  }

  void begin(const PayloadPart& part) {
    body_ = part.bytes;
    at_ = 0;
    block_ = {};
    BlockGroup group;
    blocks_left_ = take(body_, at_, group) ? group.blocks : 0;
    voxel_at_ = at_ + blocks_left_ * sizeof(VoxelBlock);
  }

  /// Goes to the next block that has voxels left. Returns false at the part's end.
  bool find() {
    if (block_.mask != 0) return true;
    if (blocks_left_ == 0) return false;
    --blocks_left_;
    return take(body_, at_, block_);
  }

  /// The part's blocks that find() has not reached.
  VoxelBlocks<Voxel> blocks_left() const {
    return {body_.data() + at_, blocks_left_, reinterpret_cast<const Voxel*>(body_.data() + voxel_at_)};
  }
  /// Skips `blocks` blocks that have `voxels` voxels in all.
  void skip_blocks(std::uint32_t blocks, std::uint64_t voxels) {
    blocks_left_ -= blocks;
    at_ += blocks * sizeof(VoxelBlock);
    voxel_at_ += std::size_t(voxels) * sizeof(Voxel);
  }

  std::uint32_t row() const { return block_.row; }
  /// Column of the block's first voxel that is left, and the length of the run from there.
  std::uint32_t first() const { return block_.first + std::uint32_t(std::countr_zero(block_.mask)); }
  std::uint32_t count() const {
    return std::uint32_t(std::countr_one(block_.mask >> std::countr_zero(block_.mask)));
  }
  Voxel voxel(std::uint32_t k) const {
    Voxel voxel;
    std::memcpy(&voxel, body_.data() + voxel_at_ + k * sizeof voxel, sizeof voxel);
    return voxel;
  }
  void skip(std::uint32_t voxels) {
    voxel_at_ += voxels * sizeof(Voxel);
    for (; voxels > 0; --voxels) block_.mask &= block_.mask - 1;
  }

 private:
  /// Moves `at` behind the group. Returns false when the group is not whole or a block leaves the slice.
  bool check_blocks(const BlockGroup& group, std::span<const std::byte> body, std::size_t& at) const {
    if (group.blocks == 0 || (body.size() - at) / sizeof(VoxelBlock) < group.blocks) return false;
    std::uint64_t voxels = 0;
    for (std::uint32_t k = 0; k < group.blocks; ++k) {
      VoxelBlock block;
      if (!take(body, at, block) || block.row >= height_ || block.first >= width_ || block.first % 64 != 0 ||
          block.mask == 0)
        return false;
      const std::uint32_t columns = width_ - block.first;
      if (columns < 64 && block.mask >> columns != 0) return false;
      voxels += std::uint64_t(std::popcount(block.mask));
    }
    if (voxels != group.voxels || (body.size() - at) / sizeof(Voxel) < group.voxels) return false;
    at += group.voxels * sizeof(Voxel);
    return true;
  }

  std::uint32_t width_, height_;
  std::span<const std::byte> body_;    ///< of the part
  std::size_t at_ = 0, voxel_at_ = 0;  ///< byte offsets of the next block and the next voxel
  std::uint32_t blocks_left_ = 0;
  VoxelBlock block_{};
};

}  // namespace ringsplat
