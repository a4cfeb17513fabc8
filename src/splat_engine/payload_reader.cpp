#include "splat_engine/payload_reader.hpp"

#include "splat/aligned_slice.hpp"
#include "splat/splat_sum.hpp"
#include "splat/voxel_run.hpp"
#include "splat/voxel_sum.hpp"
#include "view/slice_dda.hpp"

namespace ringsplat {
namespace {

/// Splits a payload of groups, which begin with a `Head`, into parts: of one group a region, or of several.
template <class Head, bool one_group>
class GroupReader : public PayloadReader {
 public:
  std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                 const std::function<bool(int)>& owned) const final {
    std::vector<PayloadPart> parts;
    for (std::size_t at = 0, begin = 0; at < body.size(); begin = at) {
      Head group;
      const int last = parts.empty() ? -1 : parts.back().region;
      if (!take(body, at, group) || group.region < last + int(one_group) || !owned(group.region) ||
          !pass_group(group, body, at))
        throw OtherBuild(fmt::format("a payload of {} bytes is not understood at byte {}", body.size(), at));
      if (group.region != last) parts.push_back({group.region, body.subspan(begin, 0)});
      PayloadPart& part = parts.back();
      part.bytes = {part.bytes.data(), part.bytes.size() + (at - begin)};
    }
    return parts;
  }

 private:
  /// Moves `at` behind the group. Returns false when the group is not whole or is none of the frame's.
  virtual bool pass_group(const Head& group, std::span<const std::byte> body, std::size_t& at) const = 0;
};

class WordReader final : public GroupReader<SplatGroup, false> {
 public:
  explicit WordReader(const SplatFrame& frame) : sum_(frame.footprint, frame.geometry.regions.rect(0)) {}

  void begin(int, const PayloadPart& part, RegionImage& image) override {
    sum_.begin(image);
    body_ = part.bytes;
    at_ = left_ = 0;
  }

  bool more() override {
    while (left_ == 0) {
      if (!take(body_, at_, group_)) return false;
      left_ = group_.count;
    }
    return true;
  }

  DrawCounts draw(std::uint32_t most) override {
    const std::uint32_t count = std::min(most, left_);
    const auto splats = body_.subspan(at_, count * sizeof(Splat));
    at_ += splats.size();
    left_ -= count;
    return sum_.draw(group_.base_x, group_.base_y, splats);
  }

  std::uint64_t composite() override { return sum_.composite(); }

 private:
  bool pass_group(const SplatGroup& group, std::span<const std::byte> body, std::size_t& at) const override {
    if ((body.size() - at) / sizeof(Splat) < group.count) return false;
    at += group.count * sizeof(Splat);
    return true;
  }

  SplatSum sum_;
  std::span<const std::byte> body_;  ///< of the part
  std::size_t at_ = 0;
  SplatGroup group_{};
  std::uint32_t left_ = 0;  ///< splats left in the group
};

/// Steps through a part of runs block by block or voxel by voxel.
class RunCursor : public GroupReader<BlockGroup, true> {
 public:
  explicit RunCursor(const FrameGeometry& geometry)
      : width_(std::uint32_t(geometry.grid.slice_width(geometry.traversal.axis))),
        height_(std::uint32_t(geometry.grid.slice_height(geometry.traversal.axis))) {}

  bool more() override { return block_.mask != 0 || blocks_left_ > 0; }

 protected:
  void begin_part(const PayloadPart& part) {
    body_ = part.bytes;
    at_ = 0;
    block_ = {};
    BlockGroup group;
    blocks_left_ = take(body_, at_, group) ? group.blocks : 0;
    voxel_at_ = at_ + blocks_left_ * sizeof(VoxelRun);
  }

  /// Goes to the next block when the last one has no voxels left. Returns false at the part's end.
  bool find() {
    if (block_.mask != 0) return true;
    if (blocks_left_ == 0) return false;
    --blocks_left_;
    return take(body_, at_, block_);
  }

  /// The part's blocks that find() has not reached.
  VoxelRuns blocks_left() const {
    return {body_.data() + at_, blocks_left_, reinterpret_cast<const PackedVoxel*>(body_.data() + voxel_at_)};
  }
  /// Skips `blocks` blocks that have `voxels` voxels in all.
  void skip_blocks(std::uint32_t blocks, std::uint64_t voxels) {
    blocks_left_ -= blocks;
    at_ += blocks * sizeof(VoxelRun);
    voxel_at_ += std::size_t(voxels) * sizeof(PackedVoxel);
  }

  /// Row and column of the block's first voxel that is left.
  std::uint32_t row() const { return block_.row; }
  std::uint32_t column() const { return block_.first + std::uint32_t(std::countr_zero(block_.mask)); }
  PackedVoxel take_voxel() {
    PackedVoxel voxel;
    std::memcpy(&voxel, body_.data() + voxel_at_, sizeof voxel);
    voxel_at_ += sizeof voxel;
    block_.mask &= block_.mask - 1;
    return voxel;
  }

 private:
  bool pass_group(const BlockGroup& group, std::span<const std::byte> body, std::size_t& at) const final {
    if (group.blocks == 0 || (body.size() - at) / sizeof(VoxelRun) < group.blocks) return false;
    std::uint64_t voxels = 0;
    for (std::uint32_t k = 0; k < group.blocks; ++k) {
      VoxelRun block;
      if (!take(body, at, block) || block.row >= height_ || block.first >= width_ || block.first % 64 != 0 ||
          block.mask == 0)
        return false;
      const std::uint32_t columns = width_ - block.first;
      if (columns < 64 && block.mask >> columns != 0) return false;
      voxels += std::uint64_t(std::popcount(block.mask));
    }
    if (voxels != group.voxels || (body.size() - at) / sizeof(PackedVoxel) < group.voxels) return false;
    at += group.voxels * sizeof(PackedVoxel);
    return true;
  }

  std::uint32_t width_, height_;
  std::span<const std::byte> body_;    ///< of the part
  std::size_t at_ = 0, voxel_at_ = 0;  ///< byte offsets of the next block and the next voxel
  std::uint32_t blocks_left_ = 0;
  VoxelRun block_{};
};

/// Draws runs without placing each voxel: all voxels of a slice lie at whole-pixel steps.
class AlignedReader final : public RunCursor {
 public:
  AlignedReader(const SplatFrame& frame, const AlignedFrame& aligned)
      : RunCursor(frame.geometry), sum_(aligned, frame.geometry.regions.rect(0)) {}

  void begin(int slice, const PayloadPart& part, RegionImage& image) override {
    sum_.begin(image, slice);
    begin_part(part);
  }

  DrawCounts draw(std::uint32_t most) override {
    const DrawnBlocks drawn = sum_.draw(blocks_left(), most);
    skip_blocks(drawn.blocks, drawn.counts.drawn + drawn.counts.clipped);
    return drawn.counts;
  }

  std::uint64_t composite() override { return sum_.composite(); }

 private:
  VoxelSum sum_;
};

/// Makes splats from runs: the same splats that the GP would make from the voxels.
class RunReader final : public RunCursor {
 public:
  explicit RunReader(const SplatFrame& frame)
      : RunCursor(frame.geometry),
        sum_(frame.footprint, frame.geometry.regions.rect(0)),
        geometry_(frame.geometry),
        footprint_(frame.footprint),
        dda_(geometry_.view, geometry_.traversal.axis, geometry_.grid.slice_width(geometry_.traversal.axis)) {
  }

  void begin(int slice, const PayloadPart& part, RegionImage& image) override {
    sum_.begin(image);
    if (std::exchange(slice_, slice) != slice) row_.reset();
    const PixelRect rect = geometry_.regions.rect(part.region);
    const KernelReach reach = kernel_reach(footprint_);
    corner_x_ = rect.x0 - reach.x - 1;
    corner_y_ = rect.y0 - reach.y - 1;
    begin_part(part);
  }

  DrawCounts draw(std::uint32_t most) override {
    splats_.resize(most);
    filled_ = 0;
    while (filled_ < most && find() && append_splat()) {
    }
    return sum_.draw(corner_x_ + base_x_, corner_y_ + base_y_,
                     std::as_bytes(std::span(splats_).first(filled_)));
  }

  std::uint64_t composite() override { return sum_.composite(); }

 private:
  /// Appends the next voxel. Returns false when it needs another base.
  ///
  /// Bases are 256 pixels apart; the first lies the kernels' reach before the region's corner, so regions of
  /// up to 250 pixels need only one.
  bool append_splat() {
    if (std::exchange(row_, row()) != row()) dda_.begin_row(slice_, int(row()));
    const glm::dvec3 position = dda_.position(column());
    const Anchored at = anchor(position.x, position.y);
    const std::int64_t x = at.anchor_x - corner_x_, y = at.anchor_y - corner_y_;
    if (filled_ == 0) {
      base_x_ = x & ~255;
      base_y_ = y & ~255;
    } else if ((x & ~255) != base_x_ || (y & ~255) != base_y_) {
      return false;
    }
    splats_[filled_++] = make_splat(footprint_, at.dx, at.dy, unpack(take_voxel()),
                                    static_cast<std::uint8_t>(x & 255), static_cast<std::uint8_t>(y & 255));
    return true;
  }

  SplatSum sum_;
  const FrameGeometry& geometry_;
  const Footprint& footprint_;
  SliceDda dda_;
  int slice_ = -1;                            ///< the DDA's slice
  std::int64_t corner_x_ = 0, corner_y_ = 0;  ///< origin of the bases
  std::optional<std::uint32_t> row_;          ///< the DDA's row in the slice
  std::int64_t base_x_ = 0, base_y_ = 0;      ///< base of the splats, from the corner
  std::vector<Splat> splats_;
  std::uint64_t filled_ = 0;  ///< how many of splats_ are filled
};

}  // namespace

std::unique_ptr<PayloadReader> make_payload_reader(const SplatFrame& frame) {
  if (frame.splats.payload == PayloadForm::words) return std::make_unique<WordReader>(frame);
  const auto aligned = AlignedFrame::of(frame.footprint, frame.geometry.view, frame.geometry.traversal.axis);
  if (aligned) return std::make_unique<AlignedReader>(frame, *aligned);
  return std::make_unique<RunReader>(frame);
}

}  // namespace ringsplat
