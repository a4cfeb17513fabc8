#include "splat/voxel_rows.hpp"

#include <limits>

#include "splat/stencil.hpp"
#include "splat/whole_steps.hpp"

namespace ringsplat {

void VoxelRows::prepare(const SliceBuffer& buffer, int left, int reach_x, int reach_y) {
  buffer_ = &buffer;
  left_ = left;
  above_ = reach_y + 1;
  const int inside = (buffer.width + block_pixels - 1) / block_pixels * block_pixels,
            behind = 2 * reach_x + 1 + most_whole_steps;
  const std::size_t needed = std::size_t(left + inside + behind) / 64 + 2;  // the last one is 0
  words_ = (needed + words_a_vector - 1) / words_a_vector * words_a_vector;
  // Vectors reach a word beyond the rows on both sides.
  filled_.assign(std::size_t(buffer.height + 2 * reach_y + 1) * words_ + 2 * words_a_vector, 0);
  inside_.assign(words_, 0);
  for (int pixel = left; pixel < left + inside; ++pixel)
    inside_[std::size_t(pixel) / 64] |= std::uint64_t{1} << pixel % 64;
  opaque_.assign(std::size_t(buffer.height) * words_, 0);
  covered_.assign(words_, 0);
  forget_rows();
}

void VoxelRows::forget_rows() {
  top_ = std::numeric_limits<int>::max();
  bottom_ = std::numeric_limits<int>::min();
}

PlacedVoxelRows VoxelRows::placed() {
  return {*buffer_, first_row(filled_), inside_.data(), words_, left_, top_, bottom_, phase_x_};
}

void VoxelRows::composite(const AlignedSlice& slice, float* image, std::ptrdiff_t row_floats,
                          float opaque_threshold, const float (*factors)[16]) {
  if (top_ >= bottom_) return;
  composite_voxels(placed(), slice, {image, row_floats, opaque_threshold, opaque_.data(), factors},
                   covered_.data());
  forget_rows();
}

void VoxelRows::clear() {
  if (top_ < bottom_) take_out(placed(), top_, bottom_);
  forget_rows();
}

}  // namespace ringsplat
