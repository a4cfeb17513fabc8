#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "ringsplat/node/frame_spec.hpp"
#include "ringsplat/splat/frame_kernel.hpp"
#include "ringsplat/splat/region_painter.hpp"

namespace ringsplat {

/// Takes a payload apart and draws it, region by region in ascending order.
class PayloadReader {
 public:
  virtual ~PayloadReader() = default;
  /// `body` must stay valid until region() is empty. Looks at all of it before anything is drawn, so that a bad
  /// message leaves no half-drawn slice; throws RunError when it is no payload for the regions that `owned` is true of.
  virtual void begin(int slice, std::span<const std::byte> body, const std::function<bool(int region)>& owned) = 0;
  /// Of the next splats; empty when there are no more.
  virtual std::optional<int> region() = 0;
  /// Draws at least one and at most `most` of that region's next splats with its painter.
  virtual DrawCounts draw(RegionPainter& painter, std::uint32_t most) = 0;
};

/// For payloads of a frame's form and precision. `geometry` must outlive it.
std::unique_ptr<PayloadReader> make_word_reader();
std::unique_ptr<PayloadReader> make_run_reader(const FrameSpec& spec, const FrameGeometry& geometry);
/// For runs in slices whose voxels lie a whole number of pixels apart (splat/aligned_slice.hpp); empty where they do not.
std::unique_ptr<PayloadReader> make_aligned_reader(const FrameSpec& spec, const FrameGeometry& geometry, const FrameKernel& kernel);

}  // namespace ringsplat
