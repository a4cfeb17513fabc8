#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "raster/slice_buffer.hpp"
#include "splat/aligned_slice.hpp"
#include "splat/frame_kernel.hpp"
#include "splat/slice_sum.hpp"
#include "splat_engine/splat_frame.hpp"

namespace ringsplat {

/// One region's part of a payload.
struct PayloadPart {
  int region = 0;
  std::span<const std::byte> bytes;
};

/// Splits a payload into its regions' parts, and draws a part, splat by splat, into a sum of its own.
class PayloadReader {
 public:
  virtual ~PayloadReader() = default;
  /// The parts of a payload, one for each region, in ascending order. Checks all of it before anything is
  /// drawn, so that a bad message leaves no half-drawn slice. Throws RunError when it is no payload for
  /// regions of which `owned` is true.
  virtual std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                         const std::function<bool(int region)>& owned) const = 0;
  /// Goes to the first splat of a part from parts(). Its bytes must stay valid until more() is false.
  virtual void begin(int slice, const PayloadPart& part) = 0;
  /// Whether the part has splats that are not drawn yet.
  virtual bool more() = 0;
  /// Draws at least one and about `most` of the part's next splats.
  virtual DrawCounts draw(std::uint32_t most) = 0;
  /// What the splats are drawn into. Its begin() must have been given the part's region.
  virtual SliceSum& sum() = 0;
};

/// The memory that a reader's sum draws in, and the largest region it is for.
struct SumMemory {
  SliceBufferMemory& memory;
  RegionSize largest;
};

/// For payloads of a frame's form and precision. `frame` and the memory must outlive it.
std::unique_ptr<PayloadReader> make_word_reader(const FrameKernel& kernel, SumMemory memory);
std::unique_ptr<PayloadReader> make_run_reader(const SplatFrame& frame, const FrameKernel& kernel,
                                               SumMemory memory);
/// For runs in slices whose voxels lie a whole number of pixels apart.
std::unique_ptr<PayloadReader> make_aligned_reader(const SplatFrame& frame, const AlignedFrame& aligned,
                                                   SumMemory memory);

}  // namespace ringsplat
