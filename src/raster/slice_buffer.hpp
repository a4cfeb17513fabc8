#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

#include "screen/regions.hpp"

namespace ringsplat {

struct FreeAlignedFloats {
  void operator()(float* floats) const;
};
/// Floats of which the first is aligned for any vector, 64 bytes at least.
using AlignedFloats = std::unique_ptr<float[], FreeAlignedFloats>;

/// Leaves the floats uninitialised. Throws std::bad_alloc.
AlignedFloats allocate_floats(std::size_t count);

/// Four neighbouring pixels of a row are a pixel block: four RGBA pixels fill the widest vector.
inline constexpr int block_pixels = 4;

inline constexpr std::ptrdiff_t floats_a_pixel = 4;  ///< premultiplied red, green, blue, opacity

/// The smallest number of whole pixel blocks with `pixels` pixels, in pixels.
inline std::ptrdiff_t in_whole_blocks(std::ptrdiff_t pixels) {
  return (pixels + block_pixels - 1) / block_pixels * block_pixels;
}

/// Half-open run of pixels in a row: first … end − 1. A new one is empty.
struct PixelRun {
  std::int32_t first = std::numeric_limits<std::int32_t>::max();
  std::int32_t end = std::numeric_limits<std::int32_t>::min();
  void include(std::int32_t other_first, std::int32_t other_end) {
    first = std::min(first, other_first);
    end = std::max(end, other_end);
  }
  bool empty() const { return first >= end; }
};

/// The pixels into which one slice of a region is summed, as the vector code sees them.
///
/// A pixel's four floats lie together, so that a vector adds whole pixels: four planes of floats would take
/// four read-modify-writes for every run of pixels instead of one.
///
/// A region is composited before the next one is drawn, so that all of a painter's regions use the same
/// memory and it stays in the processor's cache.
struct SliceBuffer {
  float* origin = nullptr;  ///< pixel (0, 0) of the region; 64-byte aligned, as is every row's first pixel
  std::ptrdiff_t row_floats = 0;  ///< floats from a row to the next
  int width = 0, height = 0;      ///< pixels of the region, without the margins
  AlignedFloats memory;
  bool holds(int x, int y) const { return x >= 0 && x < width && y >= 0 && y < height; }
};

/// Pixels of a slice buffer round its region: what is drawn over the region's edge may write there.
struct Margins {
  std::ptrdiff_t left, right, above, below;
};

/// A slice buffer for regions that are no larger than `largest`, all 0. Margins are widened to whole pixel
/// blocks.
SliceBuffer make_slice_buffer(const Margins& margins, const PixelRect& largest);

/// Composites `floats` floats of a slice's row behind the image's, and clears them in the slice. Pixels are
/// premultiplied RGBA; C = fma(1 − A, c, C) and A = fma(1 − A, a, A) in float32, with a and c clamped to [0,
/// 1] and [0, a]. Summing the opacity keeps the digits of slices as faint as 1e-7, which a product of
/// transmittances loses. Pixels whose transmittance 1 − A is below `opaque` stay as they are.
///
/// Both pointers are 64-byte aligned and `floats` is a multiple of 16.
void composite_row(float* slice, float* image, std::size_t floats, float opaque);

}  // namespace ringsplat
