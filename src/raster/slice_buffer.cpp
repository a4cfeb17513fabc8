#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/slice_buffer.cpp"
#include <hwy/aligned_allocator.h>
#include <hwy/foreach_target.h>

#include <new>
#include <utility>

#include "raster/pixel_vectors-inl.hpp"
#include "raster/slice_buffer.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

void CompositeRow(float* HWY_RESTRICT slice, float* HWY_RESTRICT image, std::size_t floats, float opaque) {
  const Floats d;
  for (std::size_t i = 0; i < floats; i += lanes) {
    composite_pixels(hn::Load(d, slice + i), hn::Set(d, opaque), image + i);
    hn::Store(hn::Zero(d), d, slice + i);
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(CompositeRow);

void composite_row(float* slice, float* image, std::size_t floats, float opaque) {
  HWY_DYNAMIC_DISPATCH(CompositeRow)(slice, image, floats, opaque);
}

void FreeAlignedFloats::operator()(float* floats) const { hwy::FreeAlignedBytes(floats, nullptr, nullptr); }

AlignedFloats allocate_floats(std::size_t count) {
  AlignedFloats floats(hwy::AllocateAligned<float>(count).release());
  if (!floats) throw std::bad_alloc();
  return floats;
}

SliceBuffer make_slice_buffer(const Margins& margins, const PixelRect& largest) {
  const std::ptrdiff_t left = in_whole_blocks(margins.left),
                       row = left + in_whole_blocks(largest.width() + margins.right),
                       rows = margins.above + largest.height() + margins.below;
  const auto floats = std::size_t(rows * row * floats_a_pixel);
  AlignedFloats memory = allocate_floats(floats);
  std::fill_n(memory.get(), floats, 0.0F);
  float* origin = memory.get() + (margins.above * row + left) * floats_a_pixel;
  return {origin, row * floats_a_pixel, largest.width(), largest.height(), std::move(memory)};
}

}  // namespace ringsplat
#endif
