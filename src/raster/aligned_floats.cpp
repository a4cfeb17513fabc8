#include "raster/aligned_floats.hpp"

#include <hwy/aligned_allocator.h>

#include <new>

namespace ringsplat {

void FreeAlignedFloats::operator()(float* floats) const { hwy::FreeAlignedBytes(floats, nullptr, nullptr); }

AlignedFloats allocate_floats(std::size_t count) {
  AlignedFloats floats(hwy::AllocateAligned<float>(count).release());
  if (!floats) throw std::bad_alloc();
  return floats;
}

}  // namespace ringsplat
