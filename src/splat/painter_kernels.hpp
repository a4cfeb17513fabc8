#pragma once
#include "raster/slice_buffer.hpp"
#include "splat/slice_sum.hpp"
#include "splat/splat.hpp"
#include "splat/stencil.hpp"

namespace ringsplat {

/// Consecutive splats to draw into a region.
struct SplatRun {
  const std::byte* bytes = nullptr;  ///< any alignment
  std::size_t count = 0;
  std::int64_t base_x = 0, base_y = 0;  ///< pixel from which anchors count, from the region's corner
};

/// Adds splats to the slice buffer. In every pixel, in float32 and in this order, rounded once for each fma
/// and each sum:
///   q = fma(a, dx, K) + fma(b, dy, c);  w = max(q, 0)²;  pixel = fma(w, (colour, opacity), pixel)
/// with colour = float(u16) · (opacity · (1 / 65535)). Nothing is written outside the region but zeros.
///
/// `anchors`: [height + 2 reach_y + 1], takes the columns of anchors, by their row from −reach_y − 1 on.
DrawCounts draw_with_stencil(const SliceBuffer& slice, const Stencil& stencil, const SplatRun& run,
                             PixelRun* anchors);

/// The same for kernels of any size, row by row within the region. K = −fma(u, u, v²) is computed on the way,
/// with (u, v) = P (dx, dy), u = fma(P00, dx, u0) and v = fma(P10, dx, v0), where u0 and v0 are rounded once
/// a row. A row is drawn where its quadratic, solved in double precision, is positive; that depends on the
/// splat alone, not on the region.
///
/// `written`: [height], takes the pixels written in each row.
DrawCounts draw_by_rows(const SliceBuffer& slice, const Footprint& footprint, const SplatRun& run,
                        PixelRun* written);

struct FootprintTable;

/// The same with the weight of a pixel looked up in the table, at the splat's phase.
DrawCounts draw_with_texture(const SliceBuffer& slice, const FootprintTable& table, const SplatRun& run,
                             PixelRun* written);

/// The same with Q in fixed point, as Pixel-Planes 5 evaluated it (Neumann 1992, sections 2.2 and 4.1).
///
/// The six coefficients are rounded to bits + 14 binary places. The sum of their products with the whole
/// offsets (dx, dy) is exact, and its last 14 places are cut off, as a bit-serial evaluator does. So Q is a
/// multiple of 2^−bits that is not above the true Q but for the coefficients' rounding, and 1 becomes 1 −
/// 2^−bits. The squares of offsets within a region of 128 pixels need 14 guard bits: the rounded D, E and F
/// then err by at most half of the result's last place. Q² and the sums are float32.
DrawCounts draw_fixed_point(const SliceBuffer& slice, const Footprint& footprint, int bits,
                            const SplatRun& run, PixelRun* written);

}  // namespace ringsplat
