#include "splat/voxel_sum.hpp"
#include "splat_engine/payload_reader.hpp"
#include "splat_engine/run_cursor.hpp"
#include "splat_engine/voxel_form.hpp"

namespace ringsplat {
namespace {

/// Draws runs without placing each voxel: all voxels of a slice lie at whole-pixel steps.
template <class Voxel>
class AlignedReader final : public PayloadReader {
 public:
  AlignedReader(const SplatFrame& frame, const AlignedFrame& aligned, SumMemory memory)
      : cursor_(frame.geometry.grid.slice_width(frame.geometry.traversal.axis),
                frame.geometry.grid.slice_height(frame.geometry.traversal.axis)),
        sum_(aligned, memory.largest, memory.memory) {}

  std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                 const std::function<bool(int)>& owned) const override {
    return cursor_.parts(body, owned);
  }

  void begin(int slice, const PayloadPart& part) override {
    sum_.begin_slice(slice);
    cursor_.begin(part);
  }

  bool more() override { return cursor_.blocks_left().count > 0; }

  DrawCounts draw(std::uint32_t most) override {
    const DrawnBlocks drawn = sum_.draw(cursor_.blocks_left(), most);
    cursor_.skip_blocks(drawn.blocks, drawn.counts.drawn + drawn.counts.clipped);
    return drawn.counts;
  }

  SliceSum& sum() override { return sum_; }

 private:
  RunCursor<Voxel> cursor_;
  VoxelSum sum_;
};

}  // namespace

std::unique_ptr<PayloadReader> make_aligned_reader(const SplatFrame& frame, const AlignedFrame& aligned,
                                                   SumMemory memory) {
  return make_for_voxels<PayloadReader, AlignedReader>(frame.splats.precision, frame, aligned, memory);
}

}  // namespace ringsplat
