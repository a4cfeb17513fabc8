#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/composite_row.cpp"
#include <hwy/foreach_target.h>

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

}  // namespace ringsplat
#endif
