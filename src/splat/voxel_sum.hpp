#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "raster/region_image.hpp"
#include "raster/slice_buffer.hpp"
#include "splat/aligned_slice.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat {

/// A region's voxels of one aligned slice. Each voxel's premultiplied colour is in the slice buffer at its
/// anchor and in the pixels from there up to the next voxel's anchor. Rows of bits begin `left` pixels before
/// the region.
struct VoxelRows {
  SliceBuffer buffer;
  /// Bits of the pixels that hold voxels, from the row of anchors in the region's first row on.
  std::uint64_t* filled = nullptr;
  const std::uint64_t* inside = nullptr;  ///< bits of the region's pixels, whole pixel blocks
  std::size_t row_words = 0;              ///< the last word of a row is 0, as is the one before the first row
  int left = 0;
  std::int64_t x = 0, y = 0;  ///< the anchor of voxel (0, 0), from the region's corner
  /// Voxels lie in rows of anchors top … bottom − 1, and surely in the first.
  int top = std::numeric_limits<int>::max(), bottom = std::numeric_limits<int>::min();
};

/// Writes the voxels whose windows meet the region, as premultiplied RGBA in float32, and sets their pixels'
/// bits. Colours and opacities, times opacity_weight, have the bits that SplatSum adds for a splat. A voxel
/// whose opacity no footprint can give becomes 0. Stops after `most` voxels or the block in which they end.
DrawnBlocks place_voxels(const AlignedSlice& slice, VoxelRows& to, const VoxelRuns& blocks,
                         std::uint64_t most);

/// Sums a slice's voxels as they lie in their rows, where these are a whole number of pixels apart: they are
/// put into the slice buffer, and composite() convolves their rows with the kernels' weights. The same bits
/// as SplatSum of their splats, drawn row by row.
class VoxelSum {
 public:
  VoxelSum(AlignedFrame frame, const PixelRect& largest);  ///< as SplatSum's

  void begin(RegionImage& image, int slice);  ///< as SplatSum's; of the slice with that index
  /// Takes voxels of the slice, in any order but each only once. Stops after `most` voxels or the block in
  /// which they end.
  DrawnBlocks draw(const VoxelRuns& blocks, std::uint64_t most);
  std::uint64_t composite();

 private:
  AlignedFrame frame_;
  AlignedSlice slice_;
  int slice_index_ = -1;
  RegionImage* image_ = nullptr;        ///< of the region begun
  VoxelRows rows_;                      ///< in the region's part of the buffer, and of:
  std::vector<std::uint64_t> filled_;   ///< [rows of anchors][words], between words that are 0
  std::vector<std::uint64_t> inside_;   ///< [words]: the region's pixels, whole pixel blocks
  std::vector<std::uint64_t> covered_;  ///< [words]: of a row, while it is swept
  bool reached_ = false;                ///< a voxel of the slice has a weight above zero in the region
};

}  // namespace ringsplat
