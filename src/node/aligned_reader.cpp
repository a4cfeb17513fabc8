#include <utility>

#include "node/payload_reader.hpp"
#include "node/run_cursor.hpp"
#include "node/voxel_form.hpp"
#include "splat/aligned_slice.hpp"

namespace ringsplat {
namespace {

/// Draws runs as they are: within a slice nothing has to be placed.
template <class Voxel>
class AlignedReader final : public PayloadReader {
 public:
  AlignedReader(const FrameGeometry& geometry, const FrameKernel& kernel)
      : geometry_(geometry),
        kernel_(kernel),
        cursor_(geometry.grid.slice_width(geometry.traversal.axis),
                geometry.grid.slice_height(geometry.traversal.axis)) {}

  std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                 const std::function<bool(int)>& owned) const override {
    return cursor_.parts(body, owned);
  }

  void begin(int slice, const PayloadPart& part) override {
    if (std::exchange(index_, slice) != slice)
      slice_ = *make_aligned_slice(kernel_, geometry_.view, geometry_.traversal.axis, slice);
    cursor_.begin(part);
  }

  bool more() override { return cursor_.blocks_left().count > 0; }

  DrawCounts draw(RegionPainter& painter, std::uint32_t most) override {
    const DrawnBlocks drawn = painter.draw_blocks(slice_, cursor_.blocks_left(), most);
    cursor_.skip_blocks(drawn.blocks, drawn.counts.drawn + drawn.counts.clipped);
    return drawn.counts;
  }

 private:
  const FrameGeometry& geometry_;
  FrameKernel kernel_;
  RunCursor<Voxel> cursor_;
  int index_ = -1;  ///< of the slice
  AlignedSlice slice_;
};

}  // namespace

std::unique_ptr<PayloadReader> make_aligned_reader(const FrameSpec& spec, const FrameGeometry& geometry,
                                                   const FrameKernel& kernel) {
  if (!make_aligned_slice(kernel, geometry.view, geometry.traversal.axis, 0)) return {};
  return make_for_voxels<PayloadReader, AlignedReader>(spec.precision, geometry, kernel);
}

}  // namespace ringsplat
