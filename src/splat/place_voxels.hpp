#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "raster/slice_buffer.hpp"
#include "splat/aligned_slice.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat {

/// Those of the 64 places x, x + step, … that lie within [low, high]; a step is 1, 2 or 4.
inline std::uint64_t places_within(std::int64_t x, int step, std::int64_t low, std::int64_t high) {
  constexpr std::uint64_t all = ~std::uint64_t{0};
  if (x >= low && x + 63 * step <= high) return all;
  const int shift = std::countr_zero(unsigned(step));
  const std::int64_t first = std::max<std::int64_t>((low - x + step - 1) >> shift, 0),
                     last = std::min<std::int64_t>((high - x) >> shift, 63);
  return first <= last ? all << first & all >> (63 - last) : 0;
}

/// A region's rows of pixels, which take the voxels of an aligned slice.
struct VoxelPlaces {
  SliceBuffer buffer;
  std::uint64_t* filled =
      nullptr;                   ///< a bit a pixel, of the region's first row, from `left` pixels before it
  std::ptrdiff_t row_words = 0;  ///< from a row's bits to the next
  int left = 0;
  std::int64_t x = 0, y = 0;  ///< the anchor of voxel (0, 0), from the region's corner
};

struct PlacedVoxels {
  std::uint32_t blocks = 0;             ///< gone through
  std::uint64_t voxels = 0, drawn = 0;  ///< theirs; of them those with a weight above zero in the region
  int top = std::numeric_limits<int>::max(), bottom = std::numeric_limits<int>::min();  ///< rows with voxels
};

/// Writes the premultiplied RGBA in float32 of those voxels whose windows meet the region: each at its anchor
/// and in the pixels from there to the next voxel's, whose bits are set. A voxel's colour, and its opacity
/// times opacity_weight, are what RegionPainter::draw adds for a splat; one whose opacity is no number that a
/// footprint can give becomes 0. Stops after `most` voxels or the block in which they end. The same bits at
/// every vector width.
PlacedVoxels place_voxels(const AlignedSlice& slice, const VoxelPlaces& to,
                          const VoxelBlocks<FloatVoxel>& blocks, std::uint64_t most);
PlacedVoxels place_voxels(const AlignedSlice& slice, const VoxelPlaces& to,
                          const VoxelBlocks<HalfVoxel>& blocks, std::uint64_t most);
PlacedVoxels place_voxels(const AlignedSlice& slice, const VoxelPlaces& to,
                          const VoxelBlocks<ByteVoxel>& blocks, std::uint64_t most);

}  // namespace ringsplat
