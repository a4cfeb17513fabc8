#pragma once
#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ringsplat/splat/aligned_slice.hpp"
#include "splat/place_voxels.hpp"
#include "splat/slice_buffer.hpp"
#include "splat/stencil.hpp"

namespace ringsplat {

/// Blocks of a row of pixels, and what convolve_blocks needs to sum the kernels that cover them.
struct BlockSums {
  const float* voxels;            ///< the first block's leftmost voxel of the topmost row that reaches it
  std::ptrdiff_t row_floats;      ///< from one of these rows to the next
  const float* weights;           ///< of the topmost row
  std::ptrdiff_t weights_floats;  ///< from a row's weights to those of the row above
  int rows, taps, voxel_floats;  ///< voxel_floats: from a voxel to the next
  int blocks;
};
/// Writes the blocks' pixels to `sums`, 64-byte aligned.
void convolve_blocks(const BlockSums& in, float* sums);

/// A region's voxels of one aligned slice, until the slice is complete: premultiplied, each in the slice
/// buffer at its anchor and in the pixels from there to the next voxel's. Then their kernels are summed pixel
/// by pixel, from the voxels round it: a pixel is written once, and not once for each of its voxels.
class VoxelRows {
 public:
  /// For slices in `buffer`, which is prepared as for draw_with_stencil and must outlive this frame's use.
  /// `left`: its pixels before the region, whole blocks.
  void prepare(const SliceBuffer& buffer, int left, int reach_x, int reach_y);

  /// Puts `count` neighbouring voxels of a row, the first of which has its anchor (x, y) pixels from the region's
  /// corner, in their places. All their windows meet the region. Each voxel of a slice once, in any order.
  /// Returns how many have a weight above zero in the region.
  template <class Voxel>
  std::uint64_t place(const AlignedSlice& slice, int x, int y, const Voxel* voxels, int count) {
    place_voxels(slice, voxels, std::size_t(count), pixel(x, y));
    mark(y, x - slice.reach_x, x + count * slice.step_x + slice.reach_x);
    anchor_x_ = x;
    top_ = std::min(top_, y);
    bottom_ = std::max(bottom_, y + 1);
    return count_drawn(slice, x, y, count);
  }

  /// Calls use(sums, x, y, pixels) for the region's pixels that kernels can cover, block by block or several
  /// at once; the last block may end behind the region. `sums` are their RGBA, to be used at once and to be
  /// changed at will, with the bits that draw_with_stencil sums when it is given the voxels row by row.
  template <class Use>
  void convolve(const AlignedSlice& slice, const Use& use) {
    if (top_ >= bottom_) return;
    const int end = std::min(bottom_ + slice.reach_y + 1, buffer_->height);
    for (int y = std::max(top_ - slice.reach_y, 0); y < end; ++y) {
      const Reaching rows = reaching(slice, y);
      for (std::size_t word = 0; word < words_; ++word) {
        int block = int(word) * 64;
        for (std::uint64_t bits = blocks_of(rows, word); bits != 0;) {
          const int skipped = std::countr_zero(bits), count = std::countr_one(bits >> skipped);
          block += skipped;
          sum(slice, rows, y, block, count);
          use(sums_.get(), block * block_pixels - left_, y, count * block_pixels);
          block += count;
          // In two steps, since a shift by all 64 bits is none.
          bits = bits >> skipped >> (count - 1) >> 1;
        }
      }
    }
  }

  /// Takes all voxels out.
  void clear();

 private:
  /// Rows of anchors, a step apart, whose kernels reach a row of pixels.
  struct Reaching {
    int first, end, step;  ///< anchors' y, from the region's corner
  };
  Reaching reaching(const AlignedSlice& slice, int y) const;
  std::uint64_t* row_blocks(int anchor_y) { return blocks_.data() + std::size_t(anchor_y + above_) * words_; }
  std::uint64_t blocks_of(const Reaching& rows, std::size_t word) const {
    std::uint64_t bits = 0;
    for (int y = rows.first; y < rows.end; y += rows.step) bits |= blocks_[std::size_t(y + above_) * words_ + word];
    return bits & inside_[word];
  }
  float* pixel(int x, int y) const { return buffer_->origin + y * buffer_->row_floats + std::ptrdiff_t{4} * x; }
  /// Columns first … last of row y.
  void mark(int y, int first, int last);
  std::uint64_t count_drawn(const AlignedSlice& slice, int x, int y, int count) const;
  void sum(const AlignedSlice& slice, const Reaching& rows, int y, int block, int count);

  const SliceBuffer* buffer_ = nullptr;
  int left_ = 0, above_ = 0;  ///< pixels of the buffer before the region; rows of anchors above it
  std::size_t words_ = 0;     ///< of a row's blocks
  /// [rows of anchors][words]: a bit for each block, from the left margin's first, that kernels of the row's
  /// voxels can cover. Their anchors lie there too.
  std::vector<std::uint64_t> blocks_;
  std::vector<std::uint64_t> inside_;  ///< [words]: the blocks with pixels of the region
  int top_ = 0, bottom_ = 0;           ///< rows of anchors top_ … bottom_ − 1, the first of which holds voxels
  int anchor_x_ = 0;                   ///< of a voxel
  hwy::AlignedFreeUniquePtr<float[]> sums_;
};

}  // namespace ringsplat
