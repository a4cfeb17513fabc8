#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "raster/region_image.hpp"
#include "raster/slice_buffer.hpp"
#include "splat/footprint.hpp"
#include "splat/splat.hpp"

namespace ringsplat {

/// Kernels whose window is larger than this in either direction are drawn row by row without a stencil.
inline constexpr int largest_stencil_window = 64;

/// What all kernels of a frame share, because D, E and F are constant over it (Neumann 1992, section 2.2):
/// the pixel blocks round an anchor that can have Q > 0, and K = D dx² + E dx dy + F dy² in each of their
/// pixels.
///
/// Pixels of a block outside the window have such a low K that Q is never positive there.
struct Stencil {
  int reach_x = 0, reach_y = 0;  ///< the window is anchor − reach … anchor + reach + 1
  std::size_t blocks = 0;        ///< multiple of 4; the last ones may be padding that draws nothing
  AlignedFloats k, dx, dy;       ///< [blocks][block_pixels]
  std::vector<std::ptrdiff_t>
      offset;  ///< [blocks]: floats from the anchor's pixel to the block's first, in the slice buffer
};

/// `row_floats`: floats from a row to the next one in the slice buffer.
Stencil make_stencil(const Footprint& footprint, std::ptrdiff_t row_floats);

/// Adds splats to the slice buffer of a region with the corner (left, top). In every pixel, in float32 and in
/// this order, rounded once for each fma and each sum:
///   q = fma(a, dx, K) + fma(b, dy, c);  w = max(q, 0)²;  pixel = fma(w, (colour, opacity), pixel)
/// with colour = float(u16) · (opacity · (1 / 65535)). Nothing is written outside the region but zeros.
///
/// With a stencil whole stencils are drawn. `written`: [height + 2 reach_y + 1], takes the columns of
/// anchors, by their row from −reach_y − 1 on.
///
/// Without, for kernels of any size, splats are drawn row by row within the region. `written`: [height],
/// takes the pixels written in each row. K = −fma(u, u, v²) is computed on the way, with (u, v) = P (dx, dy),
/// u = fma(P00, dx, u0) and v = fma(P10, dx, v0), where u0 and v0 are rounded once a row. A row is drawn
/// where its quadratic, solved in double precision, is positive; that depends on the splat alone, not on the
/// region.
DrawCounts draw_splats(const SliceBuffer& slice, const Footprint& footprint, const Stencil* stencil,
                       std::span<const Splat> splats, int left, int top, PixelRun* written);

/// Sums the kernels of one slice's splats in one region, one by one into a slice buffer, then composites the
/// sum behind the region's image (Westover 1989; Neumann 1992, section 2.3).
///
/// Made for a frame and its kernel, and used for one region after another. A pixel's sum runs in the order of
/// the splats given, with the same operations whatever the vector width, so its bits do not depend on the
/// processor, the region size or the other splats.
class SplatSum {
 public:
  /// No region may be larger than `largest`: of a frame's that is the first, as only those at the image's
  /// edge differ.
  SplatSum(const Footprint& footprint, const PixelRect& largest);

  /// Begins a slice of a region. `image` must outlive the slice; its frame has begun.
  void begin(RegionImage& image) {
    image_ = &image;
    buffer_.width = image.rect().width();
    buffer_.height = image.rect().height();
  }
  /// Adds splats. Those with a NaN or a coefficient that no footprint has count as clipped.
  DrawCounts draw(std::span<const Splat> splats);
  /// Puts the slice behind the image: C += (1 − A) c, A += (1 − A) a, with a and c clamped to [0, 1] and [0,
  /// a]. Leaves the sum empty, and costs nothing when it is. Returns how many pixels it went through.
  std::uint64_t composite();

 private:
  std::span<const Splat> without_hidden(std::span<const Splat> splats);

  /// Each of the region's rows: a run of pixels outside which nothing was written.
  std::span<const PixelRun> written();

  KernelReach reach_;
  Footprint footprint_;
  std::optional<Stencil> stencil_;  ///< where the window is small enough
  /// Where was drawn; with a stencil columns of anchors, by their row from −reach_y − 1 on.
  std::vector<PixelRun> runs_;
  std::vector<PixelRun> written_;
  SliceBuffer buffer_;
  RegionImage* image_ = nullptr;  ///< of the region begun
  bool empty_ = true;             ///< the slice buffer is 0
  std::vector<Splat> seen_;       ///< the splats not hidden, of those being drawn
};

}  // namespace ringsplat
