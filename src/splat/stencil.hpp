#pragma once
#include <cstddef>
#include <vector>

#include "raster/slice_buffer.hpp"
#include "splat/footprint.hpp"

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

/// K at the offset (x, y) from the anchor, in pixels.
float quadratic_part(const Footprint& footprint, int x, int y);

/// True when a footprint's window is small enough for a stencil.
bool has_stencil(const Footprint& footprint);

/// `row_floats`: floats from a row to the next one in the slice buffer.
Stencil make_stencil(const Footprint& footprint, std::ptrdiff_t row_floats);

}  // namespace ringsplat
