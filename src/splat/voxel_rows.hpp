#pragma once
#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "ringsplat/base/bit_runs.hpp"
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
  int rows, taps, voxel_floats;   ///< voxel_floats: from a voxel to the next
  int blocks;
};
/// Writes the blocks' pixels to `sums`, 64-byte aligned.
void convolve_blocks(const BlockSums& in, float* sums);

/// Of every four bits, of a word's first ones on: the first is set where any was.
inline std::uint64_t first_of_blocks(std::uint64_t bits) {
  static_assert(block_pixels == 4);
  bits |= bits >> 1;
  return (bits | bits >> 2) & 0x1111111111111111;
}
inline std::uint64_t whole_blocks(std::uint64_t bits) { return first_of_blocks(bits) * 15; }

/// A region's voxels of one aligned slice, until the slice is complete: premultiplied, each in the slice
/// buffer at its anchor and in the pixels from there to the next voxel's. Then their kernels are summed pixel
/// by pixel, from the voxels round it: a pixel is written once, and not once for each of its voxels.
class VoxelRows {
 public:
  /// For slices in `buffer`, which is prepared as for draw_with_stencil and must outlive this frame's use.
  /// `left`: its pixels before the region, whole blocks.
  void prepare(const SliceBuffer& buffer, int left, int reach_x, int reach_y);

  /// Puts voxels of the slice in their places, `most` or a few more; their order does not matter. (x, y): the
  /// region's corner in the image plane.
  template <class Voxel>
  PlacedVoxels place(const AlignedSlice& slice, int x, int y, const VoxelBlocks<Voxel>& blocks,
                     std::uint64_t most) {
    const VoxelPlaces to{*buffer_, filled_.data() + at(0), std::ptrdiff_t(words_),
                         left_,    slice.anchor_x - x,     slice.anchor_y - y};
    const PlacedVoxels placed = place_voxels(slice, to, blocks, most);
    phase_x_ = int(to.x & (slice.step_x - 1));
    top_ = std::min(top_, placed.top);
    bottom_ = std::max(bottom_, placed.bottom);
    return placed;
  }

  /// Calls use(sums, x, y, pixels) for the region's pixels that kernels can cover, and a few of others
  /// between them, in blocks, several at once; the last block may end behind the region. `sums` are their
  /// RGBA, to be used at once and to be changed at will, with the bits that draw_with_stencil sums when it is
  /// given the voxels row by row.
  template <class Use>
  void convolve(const AlignedSlice& slice, const Use& use) {
    if (top_ >= bottom_) return;
    const int end = std::min(bottom_ + slice.reach_y + 1, buffer_->height);
    for (int y = std::max(top_ - slice.reach_y, 0); y < end; ++y) {
      const Reaching rows = reaching(slice, y);
      const auto sum_and_use = [&](int x, int x_end) {
        sum(slice, rows, x, y, (x_end - x) / block_pixels);
        use(sums_.get(), x, y, x_end - x);
      };
      int x = 0, x_end = 0;  // covered pixels that are not summed yet
      for_each_covered(slice, rows, [&](int first, int count) {
        // A block between two runs costs less than beginning anew.
        if (x < x_end && first - x_end > block_pixels) sum_and_use(x, std::exchange(x_end, x));
        if (x == x_end) x = first;
        x_end = first + count;
      });
      if (x < x_end) sum_and_use(x, x_end);
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
  /// The pixels that hold voxels of those rows.
  std::uint64_t filled_by(const Reaching& rows, std::size_t word) const {
    std::uint64_t bits = 0;
    if (word < words_)
      for (int y = rows.first; y < rows.end; y += rows.step) bits |= filled_[at(y) + word];
    return bits;
  }
  /// The blocks of a word's pixels that kernels of such rows can cover: from reach before an anchor to
  /// reach + 1 behind it, of which a voxel fills the first ones.
  static std::uint64_t covered(const AlignedSlice& slice, std::uint64_t before, std::uint64_t here,
                               std::uint64_t behind) {
    std::uint64_t bits = here;
    if ((before | here | behind) == 0) return 0;
    for (int k = 1; k <= slice.reach_x + 2 - slice.step_x; ++k) bits |= here << k | before >> (64 - k);
    for (int k = 1; k <= slice.reach_x; ++k) bits |= here >> k | behind << (64 - k);
    return whole_blocks(bits);
  }
  /// Calls use(x, pixels) for runs of such blocks, by ascending x; those that meet between two words are two.
  template <class Use>
  void for_each_covered(const AlignedSlice& slice, const Reaching& rows, const Use& use) const {
    std::uint64_t before = 0, here = filled_by(rows, 0);
    for (std::size_t word = 0; word < words_; ++word) {
      const std::uint64_t behind = filled_by(rows, word + 1);
      for_each_bit_run(covered(slice, before, here, behind) & inside_[word],
                       [&](int first, int count) { use(int(word) * 64 + first - left_, count); });
      before = std::exchange(here, behind);
    }
  }
  void sum(const AlignedSlice& slice, const Reaching& rows, int x, int y, int blocks);

  std::size_t at(int y) const { return std::size_t(y + above_) * words_; }
  float* pixel(int x, int y) const {
    return buffer_->origin + y * buffer_->row_floats + std::ptrdiff_t{4} * x;
  }
  void forget_rows();

  const SliceBuffer* buffer_ = nullptr;
  int left_ = 0, above_ = 0;           ///< pixels of the buffer before the region; rows of anchors above it
  std::size_t words_ = 0;              ///< of a bit for each pixel of a row, from the left margin's first on
  std::vector<std::uint64_t> filled_;  ///< [rows of anchors][words]: pixels that hold the row's voxels
  std::vector<std::uint64_t> inside_;  ///< [words]: the region's pixels, whole blocks
  int top_ = 0, bottom_ = 0;  ///< rows of anchors top_ … bottom_ − 1, the first of which holds voxels
  int phase_x_ = 0;           ///< of the voxels' anchors, modulo their step
  hwy::AlignedFreeUniquePtr<float[]> sums_;
};

}  // namespace ringsplat
