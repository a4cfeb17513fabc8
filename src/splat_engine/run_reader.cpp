#include <algorithm>
#include <utility>
#include <vector>

#include "frame/frame_geometry.hpp"
#include "splat/place_run.hpp"
#include "splat/splat_sum.hpp"
#include "splat_engine/payload_reader.hpp"
#include "splat_engine/run_cursor.hpp"
#include "splat_engine/voxel_form.hpp"
#include "view/slice_dda.hpp"

namespace ringsplat {
namespace {

/// Makes splats from runs: the same splats that the GP would make from the voxels.
template <class Voxel>
class RunReader final : public PayloadReader {
 public:
  RunReader(const SplatFrame& frame, const FrameKernel& kernel, SumMemory memory)
      : sum_(kernel, memory.largest, memory.memory),
        geometry_(frame.geometry),
        footprint_(frame.footprint),
        width_(std::uint32_t(geometry_.grid.slice_width(geometry_.traversal.axis))),
        cursor_(int(width_), geometry_.grid.slice_height(geometry_.traversal.axis)),
        dda_(geometry_.view, geometry_.traversal.axis, int(width_)) {}

  std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                 const std::function<bool(int)>& owned) const override {
    return cursor_.parts(body, owned);
  }

  void begin(int slice, const PayloadPart& part) override {
    if (std::exchange(slice_, slice) != slice) row_ = nothing;
    placed_ = nothing;
    const PixelRect rect = geometry_.regions.rect(part.region);
    const KernelReach reach = kernel_reach(footprint_);
    corner_x_ = rect.x0 - reach.x - 1;
    corner_y_ = rect.y0 - reach.y - 1;
    cursor_.begin(part);
  }

  bool more() override { return cursor_.find(); }

  DrawCounts draw(std::uint32_t most) override {
    splats_.resize(most);
    filled_ = off_screen_ = 0;
    while (filled_ + off_screen_ < most && cursor_.find()) {
      if (!append_splats(
              std::min<std::uint32_t>(cursor_.count(), most - std::uint32_t(filled_ + off_screen_))))
        break;
    }
    DrawCounts counts = sum_.draw(static_cast<std::int32_t>(corner_x_ + base_x_),
                                  static_cast<std::int32_t>(corner_y_ + base_y_),
                                  std::as_bytes(std::span(splats_).first(filled_)));
    counts.clipped += off_screen_;
    return counts;
  }

  SliceSum& sum() override { return sum_; }

 private:
  /// Computes positions for the 64 columns around the run's next voxel, unless known: a row has several short
  /// runs.
  void place_block() {
    if (std::exchange(row_, cursor_.row()) != cursor_.row()) {
      dda_.begin_row(slice_, int(cursor_.row()));
      placed_ = nothing;
    }
    const std::uint32_t first = cursor_.first() / RunPlaces::capacity * RunPlaces::capacity;
    if (std::exchange(placed_, first) == first) return;
    const int count = int(std::min<std::uint32_t>(RunPlaces::capacity, width_ - first));
    place_run(footprint_, dda_, first, count, corner_x_, corner_y_, places_);
  }

  /// Appends at most `wanted` of the run's voxels. Returns false when the next one needs another base.
  ///
  /// Bases are 256 pixels apart; the first lies the kernels' reach before the region's corner, so regions of
  /// up to 250 pixels need only one.
  bool append_splats(std::uint32_t wanted) {
    place_block();
    const std::uint32_t first = cursor_.first() - placed_,
                        end = std::min<std::uint32_t>(first + wanted, RunPlaces::capacity);
    std::uint32_t k = first;
    for (; k < end; ++k) {
      const std::int32_t x = places_.anchor_x[k], y = places_.anchor_y[k];
      if (is_far(x) || is_far(y)) {
        ++off_screen_;
        continue;
      }
      if (filled_ == 0) {
        base_x_ = x & ~255;
        base_y_ = y & ~255;
      } else if ((x & ~255) != base_x_ || (y & ~255) != base_y_) {
        break;
      }
      const VoxelColour colour = unpack(cursor_.voxel(k - first));
      splats_[filled_++] = {places_.a[k],
                            places_.b[k],
                            places_.c[k],
                            weighted_opacity(footprint_, colour.opacity),
                            colour.red,
                            colour.green,
                            colour.blue,
                            static_cast<std::uint8_t>(x & 255),
                            static_cast<std::uint8_t>(y & 255)};
    }
    cursor_.skip(k - first);
    return k == end;
  }

  /// No kernel reaches so far.
  static bool is_far(std::int32_t anchor) { return anchor > (1 << 30) || anchor < -(1 << 30); }

  SplatSum sum_;
  const FrameGeometry& geometry_;
  const Footprint& footprint_;
  std::uint32_t width_;
  RunCursor<Voxel> cursor_;
  SliceDda dda_;
  int slice_ = -1;                            ///< the DDA's slice
  std::int64_t corner_x_ = 0, corner_y_ = 0;  ///< origin of the bases
  static constexpr std::uint32_t nothing = ~0U;
  std::uint32_t row_ = nothing;     ///< the DDA's row in the slice
  std::uint32_t placed_ = nothing;  ///< first of the columns in places_
  RunPlaces places_;
  std::int32_t base_x_ = 0, base_y_ = 0;  ///< base of the splats, from the corner
  std::vector<Splat> splats_;
  std::uint64_t filled_ = 0;      ///< how many of splats_ are filled
  std::uint64_t off_screen_ = 0;  ///< voxels too far from the region to reach it
};

}  // namespace

std::unique_ptr<PayloadReader> make_run_reader(const SplatFrame& frame, const FrameKernel& kernel,
                                               SumMemory memory) {
  return make_for_voxels<PayloadReader, RunReader>(frame.splats.precision, frame, kernel, memory);
}

}  // namespace ringsplat
