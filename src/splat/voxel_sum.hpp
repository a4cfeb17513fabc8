#pragma once
#include <cstdint>
#include <vector>

#include "raster/region_image.hpp"
#include "raster/slice_buffer.hpp"
#include "splat/aligned_slice.hpp"
#include "splat/voxel_kernels.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat {

/// Sums a slice's voxels as they lie in their rows, where these are a whole number of pixels apart: they are
/// put into the slice buffer, and composite() convolves their rows with the kernels' weights. The same bits
/// as SplatSum of their splats, drawn row by row.
class VoxelSum {
 public:
  VoxelSum(AlignedFrame frame, RegionSize largest);

  void begin(RegionImage& image);  ///< as SplatSum's
  /// Goes to a slice, given by its index, before the first of its regions.
  void begin_slice(int slice);
  /// Takes voxels of the slice, in any order but each only once. Stops after `most` voxels or the block in
  /// which they end.
  template <class Voxel>
  DrawnBlocks draw(const VoxelBlocks<Voxel>& blocks, std::uint64_t most) {
    rows_.x = slice_.anchor_x - image_->rect().x0;
    rows_.y = slice_.anchor_y - image_->rect().y0;
    const DrawnBlocks drawn = place_voxels(slice_, rows_, blocks, most);
    reached_ |= drawn.counts.drawn > 0;
    return drawn;
  }
  std::uint64_t composite(glm::dvec2 voxel);

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
