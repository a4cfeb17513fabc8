#include "raster/slice_buffer.hpp"

namespace ringsplat {

float* SliceBufferMemory::reserve(std::size_t floats) {
  if (floats > capacity_) {
    discard();
    floats_ = allocate_floats(floats);
    std::fill_n(floats_.get(), floats, 0.0F);
    capacity_ = floats;
  }
  return floats_.get();
}

void SliceBufferMemory::discard() {
  floats_.reset();
  capacity_ = 0;
}

SliceBuffer make_slice_buffer(const Margins& margins, RegionSize largest, SliceBufferMemory& memory) {
  const std::ptrdiff_t left = in_whole_blocks(margins.left),
                       row = left + in_whole_blocks(largest.width + margins.right),
                       rows = margins.above + largest.height + margins.below;
  float* floats = memory.reserve(std::size_t(rows * row * floats_a_pixel));
  return {floats + (margins.above * row + left) * floats_a_pixel, row * floats_a_pixel, largest.width,
          largest.height};
}

}  // namespace ringsplat
