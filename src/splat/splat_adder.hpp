#pragma once
#include <memory>
#include <span>

#include "splat/frame_kernel.hpp"
#include "splat/painter_kernels.hpp"
#include "splat/slice_sum.hpp"

namespace ringsplat {

/// Adds splats to a slice buffer by a frame's kernel, and keeps account of the pixels it wrote.
class SplatAdder {
 public:
  virtual ~SplatAdder() = default;
  virtual Margins margins() const = 0;
  /// Call once, with a buffer that has the margins round the largest region.
  virtual void prepare(const SliceBuffer& largest) = 0;
  /// `slice`: a region that is no larger, with rows of the same length.
  virtual DrawCounts add(const SliceBuffer& slice, const SplatRun& run) = 0;
  /// Each of the region's rows: a run of pixels outside which nothing was written since forget().
  virtual std::span<const PixelRun> written(const SliceBuffer& slice) = 0;
  virtual void forget() = 0;
};

/// The adder for the kernel's weights: with a stencil, row by row, in fixed point or from a table.
std::unique_ptr<SplatAdder> make_splat_adder(const FrameKernel& kernel);

}  // namespace ringsplat
