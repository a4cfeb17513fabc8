#include "splat/voxel_sum.hpp"

#include <algorithm>
#include <utility>

#include "splat/splat.hpp"

namespace ringsplat {

VoxelSum::VoxelSum(AlignedFrame frame, RegionSize largest) : frame_(std::move(frame)) {
  const KernelReach reach = frame_.reach();
  const Margins margins = window_margins(reach);
  rows_.left = int(in_whole_blocks(margins.left));
  rows_.buffer = make_slice_buffer(margins, largest);

  const int inside = int(in_whole_blocks(largest.width)), behind = int(2 * reach.x) + 1 + largest_step;
  const std::size_t words = std::size_t(rows_.left + inside + behind) / 64 + 2;  // the last one is 0
  const std::size_t above = std::size_t(reach.y) + 1, anchors = above + std::size_t(largest.height + reach.y);
  filled_.assign(1 + anchors * words + 1, 0);
  covered_.assign(words, 0);
  rows_.row_words = words;
  rows_.filled = filled_.data() + 1 + above * words;
}

void VoxelSum::begin(RegionImage& image) {
  image_ = &image;
  SliceBuffer& buffer = rows_.buffer;
  buffer.height = image.rect().height();
  if (!inside_.empty() && buffer.width == image.rect().width()) return;
  buffer.width = image.rect().width();
  inside_.assign(rows_.row_words, 0);
  const int end = rows_.left + int(in_whole_blocks(buffer.width));
  for (int pixel = rows_.left; pixel < end; ++pixel)
    inside_[std::size_t(pixel) / 64] |= std::uint64_t{1} << pixel % 64;
  rows_.inside = inside_.data();
}

void VoxelSum::begin_slice(int slice) {
  if (std::exchange(slice_index_, slice) != slice) slice_ = frame_.slice(slice);
}

std::uint64_t VoxelSum::composite(glm::dvec2 voxel) {
  if (rows_.top >= rows_.bottom) return 0;
  std::uint64_t composited = 0;
  if (reached_ || image_->touched()) {
    float factors[largest_step][16];
    const LatticeSum* lattice_sum = frame_.lattice_sum();
    for (int y = 0; y < largest_step && lattice_sum != nullptr; ++y)
      lattice_sum->fill_factors(image_->rect().x0, image_->rect().y0 + y, voxel, factors[y]);
    composited =
        composite_voxels(rows_, slice_,
                         {image_->pixels(), image_->row_floats(), image_->opaque_threshold(),
                          image_->opaque_bits(rows_.row_words), lattice_sum != nullptr ? factors : nullptr},
                         covered_.data());
    image_->slices_composited();
  } else {
    take_out(rows_, rows_.top, rows_.bottom);
  }
  rows_.top = VoxelRows().top;
  rows_.bottom = VoxelRows().bottom;
  reached_ = false;
  return composited;
}

}  // namespace ringsplat
