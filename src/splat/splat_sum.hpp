#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "raster/region_image.hpp"
#include "raster/slice_buffer.hpp"
#include "ringsplat/base/bytes.hpp"
#include "splat/frame_kernel.hpp"
#include "splat/painter_kernels.hpp"
#include "splat/splat.hpp"
#include "splat/stencil.hpp"

namespace ringsplat {

/// Sums the kernels of one slice's splats in one region, one by one into a slice buffer, then composites the
/// sum behind the region's image (Westover 1989; Neumann 1992, section 2.3).
///
/// Made for a frame and its kernel, and used for one region after another. A pixel's sum runs in the order of
/// the splats given, with the same operations whatever the vector width, so its bits do not depend on the
/// processor, the region size or the other splats.
class SplatSum {
 public:
  SplatSum(const FrameKernel& kernel, RegionSize largest);

  /// Begins a slice of a region. `image` must outlive the slice; its frame has begun.
  void begin(RegionImage& image);
  /// Adds whole splats; `splats` may have any alignment. (base_x, base_y): the pixel of the image plane from
  /// which their anchors count. Splats with a NaN or a coefficient that no footprint has count as clipped.
  DrawCounts draw(std::int64_t base_x, std::int64_t base_y, std::span<const std::byte> splats);
  /// Puts the slice behind the image: C += (1 − A) c, A += (1 − A) a, with a and c clamped to [0, 1] and [0,
  /// a]. Leaves the sum empty, and costs nothing when it is. `voxel`: where a voxel of the slice lies in the
  /// image plane, in pixels; the exact normalisation divides a and c by the lattice's sum there first.
  /// Returns how many pixels it went through.
  std::uint64_t composite(glm::dvec2 voxel);

 private:
  std::span<const std::byte> without_hidden(std::int64_t left, std::int64_t top,
                                            std::span<const std::byte> splats);

  /// Each of the region's rows: a run of pixels outside which nothing was written.
  std::span<const PixelRun> written();

  KernelReach reach_;
  FrameKernel kernel_;
  std::optional<Stencil> stencil_;  ///< of StencilWeights
  /// Where was drawn; with a stencil columns of anchors, by their row from −reach_y − 1 on.
  std::vector<PixelRun> runs_;
  std::vector<PixelRun> written_;
  SliceBuffer buffer_;
  RegionImage* image_ = nullptr;  ///< of the region begun
  bool empty_ = true;             ///< the slice buffer is 0
  Bytes seen_;                    ///< the splats not hidden, of those being drawn
};

}  // namespace ringsplat
