#pragma once
#include <cstddef>
#include <cstdint>

#include "raster/slice_buffer.hpp"
#include "splat/aligned_slice.hpp"

namespace ringsplat {

/// Words of a row of bits, a bit a pixel, are whole vectors of as many.
inline constexpr std::size_t words_a_vector = 8;

/// A region's voxels of one aligned slice: premultiplied, each in the slice buffer at its anchor and in the
/// pixels from there to the next voxel's. Rows of bits begin `left` pixels before the region.
struct PlacedVoxelRows {
  SliceBuffer buffer;
  std::uint64_t* filled = nullptr;        ///< which pixels hold voxels, of the region's first row of anchors
  const std::uint64_t* inside = nullptr;  ///< the region's pixels, whole blocks
  std::size_t row_words = 0;  ///< whole vectors; the last one is 0, as is the one before the first
  int left = 0;
  int top = 0, bottom = 0;  ///< rows of anchors top … bottom − 1, the first of which holds voxels
  int phase_x = 0;          ///< of the voxels' anchors, modulo their step
};

/// A region's composited pixels.
struct ImageRows {
  float* first = nullptr;           ///< RGBA of pixel (0, 0), 64-byte aligned as all rows' are
  std::ptrdiff_t row_floats = 0;    ///< from a row to the next
  float opaque_threshold = 0;       ///< transmittances below it count as 0
  std::uint64_t* opaque = nullptr;  ///< rows of bits: blocks of which all pixels are opaque
  /// Of a block's sums, in row y the (y % most_whole_steps)-th; null: 1.
  const float (*factors)[16] = nullptr;
};

/// Sums in each pixel the kernels of the voxels round it, so that a pixel is written once and not once for
/// each of its voxels; composites them behind the image, but for what is opaque there; and takes the voxels
/// out. `covered` has room for a row of bits. The bits that draw_with_stencil sums, given the voxels row by
/// row, and composite_row makes of them.
void composite_voxels(const PlacedVoxelRows& voxels, const AlignedSlice& slice, const ImageRows& image,
                      std::uint64_t* covered);

/// Takes the voxels out of rows of anchors first … end − 1.
void take_out(const PlacedVoxelRows& voxels, int first, int end);

}  // namespace ringsplat
