#include "splat/voxel_sum.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "splat/place_voxels.hpp"
#include "splat/splat.hpp"

namespace ringsplat {

VoxelSum::VoxelSum(AlignedFrame frame, RegionSize largest, SliceBufferMemory& memory)
    : frame_(std::move(frame)), memory_(memory) {
  const KernelReach reach = frame_.reach();
  const Margins margins = window_margins(reach);
  left_ = int(in_whole_blocks(margins.left));
  above_ = int(reach.y) + 1;
  buffer_ = make_slice_buffer(margins, largest, memory_);

  const int inside = int(in_whole_blocks(largest.width)), behind = int(2 * reach.x) + 1 + largest_step;
  const std::size_t needed = std::size_t(left_ + inside + behind) / 64 + 2;  // the last one is 0
  words_ = (needed + words_a_vector - 1) / words_a_vector * words_a_vector;
  // Vectors reach a word beyond the rows on both sides.
  const std::size_t rows_of_anchors = std::size_t(largest.height) + 2 * std::size_t(reach.y) + 1;
  filled_.assign(rows_of_anchors * words_ + 2 * words_a_vector, 0);
  covered_.assign(words_, 0);
  forget_rows();
}

VoxelSum::~VoxelSum() {
  if (top_ < bottom_) memory_.discard();
}

void VoxelSum::begin(RegionImage& image) {
  image_ = &image;
  buffer_.height = image.rect().height();
  if (!inside_.empty() && buffer_.width == image.rect().width()) return;
  buffer_.width = image.rect().width();
  inside_.assign(words_, 0);
  const int end = left_ + int(in_whole_blocks(buffer_.width));
  for (int pixel = left_; pixel < end; ++pixel)
    inside_[std::size_t(pixel) / 64] |= std::uint64_t{1} << pixel % 64;
}

void VoxelSum::begin_slice(int slice) {
  if (std::exchange(slice_index_, slice) != slice) slice_ = frame_.slice(slice);
}

void VoxelSum::forget_rows() {
  top_ = std::numeric_limits<int>::max();
  bottom_ = std::numeric_limits<int>::min();
  reached_ = false;
}

PlacedVoxelRows VoxelSum::placed() {
  return {buffer_,        filled_.data() + words_a_vector + std::size_t(above_) * words_,
          inside_.data(), words_,
          left_,          top_,
          bottom_,        phase_x_};
}

template <class Voxel>
DrawnBlocks VoxelSum::draw(const VoxelBlocks<Voxel>& blocks, std::uint64_t most) {
  const VoxelPlaces to{buffer_,
                       placed().filled,
                       std::ptrdiff_t(words_),
                       left_,
                       slice_.anchor_x - image_->rect().x0,
                       slice_.anchor_y - image_->rect().y0};
  const PlacedVoxels drawn = place_voxels(slice_, to, blocks, most);
  phase_x_ = int(to.x & (slice_.step_x - 1));
  top_ = std::min(top_, drawn.top);
  bottom_ = std::max(bottom_, drawn.bottom);
  reached_ |= drawn.drawn > 0;
  return {drawn.blocks, {drawn.drawn, drawn.voxels - drawn.drawn, 0}};
}
template DrawnBlocks VoxelSum::draw(const VoxelBlocks<FloatVoxel>&, std::uint64_t);
template DrawnBlocks VoxelSum::draw(const VoxelBlocks<HalfVoxel>&, std::uint64_t);
template DrawnBlocks VoxelSum::draw(const VoxelBlocks<ByteVoxel>&, std::uint64_t);

std::uint64_t VoxelSum::composite(glm::dvec2 voxel) {
  if (top_ >= bottom_) return 0;
  std::uint64_t composited = 0;
  if (reached_ || image_->touched()) {
    float factors[4][16];
    const LatticeSum* lattice_sum = frame_.lattice_sum();
    if (lattice_sum != nullptr)
      lattice_sum->fill_factors(image_->rect().x0, image_->rect().y0, voxel, factors);
    composited = composite_voxels(placed(), slice_,
                                  {image_->pixels(), image_->row_floats(), image_->opaque_threshold(),
                                   image_->opaque_bits(words_), lattice_sum != nullptr ? factors : nullptr},
                                  covered_.data());
    image_->slices_composited();
  } else {
    take_out(placed(), top_, bottom_);
  }
  forget_rows();
  return composited;
}

}  // namespace ringsplat
