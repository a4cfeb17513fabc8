#include "raster/slice_buffer.hpp"

#include <hwy/aligned_allocator.h>

#include <new>

namespace ringsplat {

void FreeAlignedFloats::operator()(float* floats) const { hwy::FreeAlignedBytes(floats, nullptr, nullptr); }

AlignedFloats allocate_floats(std::size_t count) {
  AlignedFloats floats(hwy::AllocateAligned<float>(count).release());
  if (!floats) throw std::bad_alloc();
  return floats;
}

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
