#pragma once
#include <string>
#include <vector>

#include "ringsplat/splat/region_painter.hpp"
#include "splat/slice_buffer.hpp"
#include "splat/stencil.hpp"

namespace ringsplat {

/// Adds splats to the slice buffer. In every pixel, in float32 and in this order, rounded once for each fma and each sum:
///   q = fma(a, dx, K) + fma(b, dy, c);  w = max(q, 0)²;  pixel = fma(w, (colour, opacity), pixel)
/// with colour = float(u16) · (opacity · (1 / 65535)). Nothing is written outside the region but zeros.
DrawCounts draw_with_stencil(const SliceBuffer& slice, const Stencil& stencil, const SplatRun& run);

/// The same for kernels of any size, row by row within the region; K = −fma(u, u, v²) with (u, v) = P (dx, dy) is
/// made on the way (u = fma(P00, dx, u0), v = fma(P10, dx, v0); u0 and v0 are rounded once a row). A row takes part
/// where its quadratic, solved in double precision, is positive; that depends on the splat alone, not on the
/// region.
DrawCounts draw_by_rows(const SliceBuffer& slice, const Footprint& footprint, const SplatRun& run);

/// Puts `floats` floats of a row behind the image and clears them in the slice: premultiplied RGBA pixels,
/// C = fma(1 − A, c, C) and A = fma(1 − A, a, A), in float32. Summing the opacity keeps the digits of slices as faint as 1e-7,
/// which a product of transmittances loses. Pixels whose transmittance 1 − A is below `opaque` stay as they are.
/// Both pointers are 64-byte aligned and `floats` is a multiple of 16.
void composite_row(float* slice, float* image, std::size_t floats, float opaque);

/// The instruction sets this program has and this processor supports, best first; for tests that compare
/// them.
std::vector<std::string> vector_targets();
/// Uses only the named one from now on; all again when empty. Not for use while another thread draws.
void use_vector_target(const std::string& name);

}  // namespace ringsplat
