#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "splat/place_voxels.hpp"
#include "splat/sweep_voxels.hpp"

namespace ringsplat {

/// A region's voxels of one aligned slice, until the slice is complete, and which pixels of the region are
/// opaque.
class VoxelRows {
 public:
  /// For slices in `buffer`, which is prepared as for draw_with_stencil and must outlive this frame's use.
  /// `left`: its pixels before the region, whole blocks. Nothing is opaque.
  void prepare(const SliceBuffer& buffer, int left, int reach_x, int reach_y);

  /// Puts voxels of the slice in their places, `most` or a few more; their order does not matter. (x, y): the
  /// region's corner in the image plane.
  template <class Voxel>
  PlacedVoxels place(const AlignedSlice& slice, int x, int y, const VoxelBlocks<Voxel>& blocks,
                     std::uint64_t most) {
    const VoxelPlaces to{*buffer_, first_row(filled_), std::ptrdiff_t(words_),
                         left_,    slice.anchor_x - x, slice.anchor_y - y};
    const PlacedVoxels placed = place_voxels(slice, to, blocks, most);
    phase_x_ = int(to.x & (slice.step_x - 1));
    top_ = std::min(top_, placed.top);
    bottom_ = std::max(bottom_, placed.bottom);
    return placed;
  }

  /// Composites the slice behind the region's image, rows of RGBA that are 64-byte aligned, and takes its
  /// voxels out. Pixels whose transmittance is below the threshold are left as they are. `factors`: of the
  /// sums in the region's first four by four pixels, which all others repeat, each once for each channel; or
  /// null.
  void composite(const AlignedSlice& slice, float* image, std::ptrdiff_t row_floats, float opaque_threshold,
                 const float (*factors)[16]);

  /// Takes all voxels out.
  void clear();

 private:
  PlacedVoxelRows placed();
  /// Of the region's first row of anchors.
  std::uint64_t* first_row(std::vector<std::uint64_t>& bits) const {
    return bits.data() + words_a_vector + std::size_t(above_) * words_;
  }
  void forget_rows();

  const SliceBuffer* buffer_ = nullptr;
  int left_ = 0, above_ = 0;            ///< pixels of the buffer before the region; rows of anchors above it
  std::size_t words_ = 0;               ///< of a bit for each pixel of a row, from the left margin's first on
  std::vector<std::uint64_t> filled_;   ///< [rows of anchors][words], behind one vector that is 0
  std::vector<std::uint64_t> inside_;   ///< [words]: the region's pixels, whole blocks
  std::vector<std::uint64_t> opaque_;   ///< [rows of pixels][words]
  std::vector<std::uint64_t> covered_;  ///< [words]: of a row, while it is swept
  int top_ = 0, bottom_ = 0;  ///< rows of anchors top_ … bottom_ − 1, the first of which holds voxels
  int phase_x_ = 0;           ///< of the voxels' anchors, modulo their step
};

}  // namespace ringsplat
