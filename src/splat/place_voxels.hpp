#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "raster/slice_buffer.hpp"
#include "splat/aligned_slice.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat {

/// A bit for each of the 64 places x, x + step, … that lies within [low, high]. A step is 1, 2 or 4.
inline std::uint64_t places_within(std::int64_t x, int step, std::int64_t low, std::int64_t high) {
  constexpr std::uint64_t all = ~std::uint64_t{0};
  if (x >= low && x + 63 * step <= high) return all;
  const int shift = std::countr_zero(unsigned(step));
  const std::int64_t first = std::max<std::int64_t>((low - x + step - 1) >> shift, 0),
                     last = std::min<std::int64_t>((high - x) >> shift, 63);
  return first <= last ? all << first & all >> (63 - last) : 0;
}

/// Where a region takes the voxels of an aligned slice.
struct VoxelPlaces {
  SliceBuffer buffer;
  /// A bit for each pixel of the region's first row, from `left` pixels before it on.
  std::uint64_t* filled = nullptr;
  std::ptrdiff_t row_words = 0;  ///< from a row's bits to the next
  int left = 0;
  std::int64_t x = 0, y = 0;  ///< the anchor of voxel (0, 0), from the region's corner
};

struct PlacedVoxels {
  std::uint32_t blocks = 0;  ///< gone through
  std::uint64_t voxels = 0;  ///< of these blocks
  std::uint64_t drawn = 0;   ///< of these voxels: with a weight above zero in the region
  /// Voxels lie in rows top … bottom − 1.
  int top = std::numeric_limits<int>::max(), bottom = std::numeric_limits<int>::min();
};

/// Writes the voxels whose windows meet the region, as premultiplied RGBA in float32: each at its anchor and
/// in the pixels from there up to the next voxel's anchor, and sets these pixels' bits. Colours and
/// opacities, times opacity_weight, have the bits that SplatSum adds for a splat. A voxel whose opacity no
/// footprint can give becomes 0. Stops after `most` voxels or the block in which they end. The bits are the
/// same at every vector width.
PlacedVoxels place_voxels(const AlignedSlice& slice, const VoxelPlaces& to,
                          const VoxelBlocks<FloatVoxel>& blocks, std::uint64_t most);
PlacedVoxels place_voxels(const AlignedSlice& slice, const VoxelPlaces& to,
                          const VoxelBlocks<HalfVoxel>& blocks, std::uint64_t most);
PlacedVoxels place_voxels(const AlignedSlice& slice, const VoxelPlaces& to,
                          const VoxelBlocks<ByteVoxel>& blocks, std::uint64_t most);

}  // namespace ringsplat
